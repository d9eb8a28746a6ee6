"""One declaration for a struct on both sides: a dataclass becomes a WGSL struct and the numpy dtype of the same bytes.

For example:

    class Light(Struct):                        struct Light {
        position_ws: Vec3f              ->          position_ws: vec3f,
        kind: U32                                   kind: u32,
                                                };
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import cache
from typing import Annotated, dataclass_transform, get_type_hints

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


def _member(wgsl_type: str) -> tuple[str, int, int, int]:
    """numpy scalar, components, alignment and size in bytes of a WGSL type (WGSL specification, section 14.4.1)."""
    if wgsl_type.startswith("array"):
        return "<f4", 0, 16, 0
    if wgsl_type.startswith("vec"):
        count = int(wgsl_type[3])
        return _SCALARS[wgsl_type[4]], count, 8 if count == 2 else 16, 4 * count
    return _SCALARS[wgsl_type[0]], 1, 4, 4


def _wgsl_types(struct: type[Struct]) -> dict[str, str]:
    hints = get_type_hints(struct, include_extras=True)
    return {field.name: hints[field.name].__metadata__[0] for field in fields(struct)}  # type: ignore[arg-type]


@cache
def dtype(struct: type[Struct]) -> np.dtype:
    """The numpy dtype with the offsets and padding of the WGSL struct in a uniform or storage buffer.

    An array at its end counts as empty.
    """
    names, formats, offsets, end, largest = [], [], [], 0, 4
    for name, wgsl_type in _wgsl_types(struct).items():
        scalar, count, alignment, size = _member(wgsl_type)
        offset = -(-end // alignment) * alignment
        names.append(name)
        formats.append(scalar if count == 1 else (scalar, (count,)))
        offsets.append(offset)
        end, largest = offset + size, max(largest, alignment)
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
        for name, member in asdict(value).items():  # type: ignore[call-overload]
            if isinstance(member, np.ndarray):
                assert len(values) == 1, "structs that end in an array have no array"
                rows = member.astype("<f4").tobytes()
            else:
                array[index][name] = member
    return array.tobytes() + rows
