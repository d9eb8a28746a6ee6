"""One declaration for a struct on both sides: a dataclass becomes a WGSL struct and the numpy dtype of the same bytes.

For example:

    class Light(Struct):                        struct Light {
        center_ws: Vec3f                ->          center_ws: vec3f,
        kind: U32                                   kind: u32,
                                                };

A member may be a struct itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, Any, dataclass_transform, get_type_hints

import numpy as np
import numpy.typing as npt

from softshadows.errors import ShaderError

# A field's type for Python, and what it is in WGSL.
F32 = Annotated[float, "f32"]
U32 = Annotated[int, "u32"]
I32 = Annotated[int, "i32"]
Vec2f = Annotated[tuple[float, float], "vec2f"]
Vec3f = Annotated[tuple[float, float, float], "vec3f"]
Vec4f = Annotated[tuple[float, float, float, float], "vec4f"]
Vec2u = Annotated[tuple[int, int], "vec2u"]
Vec4u = Annotated[tuple[int, int, int, int], "vec4u"]
ArrayOfVec4f = Annotated[npt.NDArray[np.float32], "array<vec4f>"]
"""(n, 4), as many as there are: a struct's last member."""

_STRUCTS: dict[str, type[Struct]] = {}
"""Every struct that Python shares with a shader, by name."""

_SCALARS = {"f": "<f4", "u": "<u4", "i": "<i4"}


@dataclass_transform(frozen_default=True)
class Struct:
    """Base of the shared structs. Subclasses are frozen dataclasses with fields of the types above."""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)
        earlier = _STRUCTS.setdefault(cls.__name__, cls)
        assert earlier.__module__ == cls.__module__, f"two structs are called {cls.__name__}: shaders know one"
        _STRUCTS[cls.__name__] = cls


def struct_named(name: str, where: str) -> type[Struct]:
    """The struct that a shader asks for at `where`. Raises ShaderError where no imported module declares one."""
    if name not in _STRUCTS:
        raise ShaderError(f"{where}: no struct {name!r} is declared in Python; known: {', '.join(sorted(_STRUCTS))}")
    return _STRUCTS[name]


def nested(struct: type[Struct]) -> list[type[Struct]]:
    """The structs among its members."""
    return [_STRUCTS[wgsl_type] for wgsl_type in _wgsl_types(struct).values() if wgsl_type in _STRUCTS]


def _member(wgsl_type: str) -> tuple[str | np.dtype, int, int, int]:
    """numpy type, components, alignment and size in bytes of a WGSL type (WGSL specification, section 14.4.1)."""
    if wgsl_type in _STRUCTS:
        inner = dtype(_STRUCTS[wgsl_type])
        return inner, 1, _alignment(_STRUCTS[wgsl_type]), inner.itemsize
    if wgsl_type.startswith("array"):
        return "<f4", 0, 16, 0
    if wgsl_type.startswith("vec"):
        count = int(wgsl_type[3])
        return _SCALARS[wgsl_type[4]], count, 8 if count == 2 else 16, 4 * count
    return _SCALARS[wgsl_type[0]], 1, 4, 4


def _wgsl_types(struct: type[Struct]) -> dict[str, str]:
    types = {}
    for name, hint in get_type_hints(struct, include_extras=True).items():
        types[name] = hint.__name__ if hint in _STRUCTS.values() else hint.__metadata__[0]
    return types


def _alignment(struct: type[Struct]) -> int:
    return max(_member(wgsl_type)[2] for wgsl_type in _wgsl_types(struct).values())


@cache
def dtype(struct: type[Struct]) -> np.dtype:
    """The numpy dtype with the offsets and padding of the WGSL struct in a uniform or storage buffer.

    An array at its end counts as empty.
    """
    names, formats, offsets, end, largest = [], [], [], 0, _alignment(struct)
    for name, wgsl_type in _wgsl_types(struct).items():
        scalar, count, alignment, size = _member(wgsl_type)
        offset = -(-end // alignment) * alignment
        names.append(name)
        formats.append(scalar if count == 1 else (scalar, (count,)))
        offsets.append(offset)
        end = offset + size
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": -(-end // largest) * largest})


def wgsl(struct: type[Struct]) -> str:
    """The WGSL declaration of the struct."""
    members = "".join(f"    {name}: {wgsl_type},\n" for name, wgsl_type in _wgsl_types(struct).items())
    return f"struct {struct.__name__} {{\n{members}}};\n"


def pack(*values: Struct) -> bytes:
    """The bytes of one struct, or of an array of structs of one type."""
    array = np.zeros(len(values), dtype(type(values[0])))
    rows = b""  # of the array at the struct's end
    for index, value in enumerate(values):
        members: dict[str, Any] = asdict(value)  # type: ignore[call-overload]
        for name in [name for name, member in members.items() if isinstance(member, np.ndarray)]:
            assert len(values) == 1, "structs that end in an array have no array"
            rows = np.asarray(members.pop(name), "<f4").tobytes()
        _fill(array[index], members)
    return array.tobytes() + rows


def _fill(row: np.void, members: Mapping[str, Any]) -> None:
    for name, member in members.items():
        if isinstance(member, Mapping):
            _fill(row[name], member)
        else:
            row[name] = member
