"""Wavefront OBJ and its MTL materials to Scene: polygons, diffuse colour and texture, emission, opacity.

A reader of our own, because trimesh counts relative (negative) indices from the end of the file, where the format
counts them from the line that uses them. Colours are taken as linear, as they stand.
"""

from __future__ import annotations

import itertools
import math
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.load.files import Folder, read_scene_file
from softshadows.scene.load.images import TOLERATED_CODES, EncodedImage, decode_images
from softshadows.scene.model import Material, Mesh, Node, Scene, Texture

MAX_INDEX = 2**31 - 1
ABSENT = -1
"""Stands for a texture coordinate or normal that a corner does not have."""

IGNORED = frozenset({"o", "g", "s", "mg", "vp", "lod", "shadow_obj", "trace_obj", "bevel", "c_interp", "d_interp"})
SKIPPED = {"l": "lines", "p": "points", "curv": "curves", "curv2": "curves", "surf": "free-form surfaces"}
MASK_CUTOFF = 0.5


@dataclass
class _Statements:
    """What an OBJ file says: vertex data, and per material the corners of its triangles, three indices each."""

    positions: array = field(default_factory=lambda: array("d"))
    colors: array = field(default_factory=lambda: array("d"))
    texcoords: array = field(default_factory=lambda: array("d"))
    normals: array = field(default_factory=lambda: array("d"))
    corners: dict[str, array] = field(default_factory=dict)
    libraries: list[tuple[str, str]] = field(default_factory=list)


def load_obj(path: Path, on_missing: str) -> Scene:
    """Read an .obj file: one mesh per material. Raises SceneError; `pointer` is the line."""
    scene = Scene(name=path.stem)
    statements = _parse(path, scene.warnings)
    folder = Folder(path)
    materials = _materials(statements.libraries, folder, on_missing, scene.warnings)
    for name, corners in statements.corners.items():
        if name and name not in materials:
            scene.warnings.append(f"material {name!r} is not defined: the default one is used")
        material = materials.get(name) or Material(name=name, double_sided=True)
        scene.nodes.append(Node(_mesh(statements, np.asarray(corners).reshape(-1, 3), material, path), name=name))
    if not scene.nodes:
        raise SceneError("the file has no faces", code="MESH_EMPTY", file=path)
    return scene


def _lines(data: bytes) -> Iterator[tuple[str, list[str], str]]:
    """(pointer, words, the text behind the first word) of each statement; continued lines joined, comments dropped."""
    continued = ""
    for number, line in enumerate(data.decode("utf-8", errors="replace").split("\n"), start=1):
        text = line.rstrip("\r")
        if text.endswith("\\"):
            continued += text[:-1] + " "
            continue
        statement, continued = (continued + text).partition("#")[0].strip(), ""
        if statement:
            words = statement.split()
            yield f"line {number}", words, statement[len(words[0]) :].strip()


def _parse(path: Path, warnings: list[str]) -> _Statements:
    result = _Statements()
    current = ""
    for pointer, words, rest in _lines(read_scene_file(path)):
        keyword, *values = words
        if keyword == "v":
            position = _floats(values, (3, 4, 6, 7), path, pointer)
            result.positions.extend(position[:3])
            result.colors.extend(position[-3:] if len(position) > 4 else (1.0, 1.0, 1.0))
        elif keyword == "vt":
            result.texcoords.extend((*_floats(values, (1, 2, 3), path, pointer), 0.0)[:2])
        elif keyword == "vn":
            result.normals.extend(_floats(values, (3,), path, pointer))
        elif keyword == "f":
            _add_face(result, current, values, path, pointer)
        elif keyword == "usemtl":
            current = rest
        elif keyword == "mtllib":
            result.libraries.append((rest, pointer))
        elif keyword in SKIPPED:
            _warn_once(warnings, f"{SKIPPED[keyword]} are skipped")
        elif keyword not in IGNORED:
            _warn_once(warnings, f"statements {keyword[:20]!r} are ignored")
    return result


def _warn_once(warnings: list[str], message: str) -> None:
    if message not in warnings:
        warnings.append(message)


def _floats(values: list[str], legal_counts: tuple[int, ...], path: Path, pointer: str) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, values))
    except ValueError:
        raise SceneError(
            f"expected numbers, got {' '.join(values)[:60]!r}", code="OBJ_SYNTAX", file=path, pointer=pointer
        ) from None
    if len(numbers) not in legal_counts:
        message = f"expected {' or '.join(map(str, legal_counts))} numbers, got {len(numbers)}"
        raise SceneError(message, code="OBJ_SYNTAX", file=path, pointer=pointer)
    if not all(map(math.isfinite, numbers)):
        raise SceneError("expected finite numbers", code="ACCESSOR_INVALID_FLOAT", file=path, pointer=pointer)
    return numbers


def _add_face(result: _Statements, material: str, words: list[str], path: Path, pointer: str) -> None:
    """Append the polygon as a fan of triangles around its first corner."""
    counts = (len(result.positions) // 3, len(result.texcoords) // 2, len(result.normals) // 3)
    if len(words) < 3:
        raise SceneError(f"a face needs three corners, got {len(words)}", code="OBJ_SYNTAX", file=path, pointer=pointer)
    try:
        corners = [_corner(word, counts) for word in words]
    except ValueError:
        message = f"expected corners such as 1, 1/2, 1//3 or 1/2/3, got {' '.join(words)[:60]!r}"
        raise SceneError(message, code="OBJ_SYNTAX", file=path, pointer=pointer) from None
    except IndexError as error:
        raise SceneError(str(error), code="ACCESSOR_INDEX_OOB", file=path, pointer=pointer) from None
    target = result.corners.setdefault(material, array("i"))
    for second, third in itertools.pairwise(corners[1:]):
        target.extend((*corners[0], *second, *third))


def _corner(word: str, counts: tuple[int, int, int]) -> tuple[int, int, int]:
    """Zero-based (position, texture coordinate, normal) of `1/2/3`; ABSENT for what is left out."""
    parts = word.split("/")
    if len(parts) > 3 or not parts[0]:
        raise ValueError(word)
    position, texcoord, normal = (_index(part, count) for part, count in zip((*parts, "", "")[:3], counts, strict=True))
    return position, texcoord, normal


def _index(text: str, count: int) -> int:
    if not text:
        return ABSENT
    number = int(text)
    index = number - 1 if number > 0 else number + count  # negative: relative to what has been read so far
    if number == 0 or not 0 <= index < MAX_INDEX:
        raise IndexError(f"index {text[:20]} is outside 1..{count}")
    return index


def _mesh(statements: _Statements, corners: np.ndarray, material: Material, path: Path) -> Mesh:
    """The triangles of one material; every combination of position, texture coordinate and normal is a vertex."""
    columns = (
        ("position", np.asarray(statements.positions).reshape(-1, 3)),
        ("texture coordinate", np.asarray(statements.texcoords).reshape(-1, 2)),
        ("normal", np.asarray(statements.normals).reshape(-1, 3)),
    )
    for column, (what, values) in enumerate(columns):  # only now, since a face may name vertices that follow it
        highest = int(corners[:, column].max())
        if highest >= len(values):
            message = f"a face names {what} {highest + 1}, the file has {len(values)}"
            raise SceneError(message, code="ACCESSOR_INDEX_OOB", file=path)
    vertices, triangles = np.unique(corners, axis=0, return_inverse=True)
    (_, positions), (_, texcoords), (_, normals) = columns
    colors = np.asarray(statements.colors).reshape(-1, 3)
    has_colors = bool((colors != 1.0).any())
    return Mesh(
        positions=_float32(positions, vertices[:, 0]),
        triangles=triangles.reshape(-1, 3).astype(np.uint32),
        normals=_float32(normals, vertices[:, 2]) if len(normals) else None,
        texcoords=_texcoords(_float32(texcoords, vertices[:, 1])) if len(texcoords) else None,
        colors=_with_alpha(_float32(colors, vertices[:, 0])) if has_colors else None,
        material=material,
        name=material.name,
    )


def _float32(values: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """`values[indices]` as float32, zero where the index is ABSENT; Mesh refuses numbers too large for float32."""
    with np.errstate(over="ignore"):
        return np.where(indices[:, None] == ABSENT, 0.0, values[indices]).astype(np.float32)


def _texcoords(first: np.ndarray) -> np.ndarray:
    """Both coordinate sets, (2, n, 2); OBJ counts v from the bottom of the image, we count from its top."""
    return np.stack([first * (1.0, -1.0) + (0.0, 1.0), np.zeros_like(first)])


def _with_alpha(colors: np.ndarray) -> np.ndarray:
    return np.hstack([colors, np.ones((len(colors), 1), np.float32)])


def _materials(
    libraries: list[tuple[str, str]], folder: Folder, on_missing: str, warnings: list[str]
) -> dict[str, Material]:
    """The materials of all MTL files, by name. With `on_missing="warn"` a file that cannot be read is a warning."""
    materials: dict[str, Material] = {}
    images: list[tuple[Material, EncodedImage]] = []
    for name, pointer in libraries:
        try:
            data = folder.read_path(_portable(name), pointer, missing_code="MATERIALS_MISSING")
        except SceneError as error:
            _raise_or_warn(error, on_missing, warnings)
            continue
        for material, texture_name, line in _parse_mtl(data, folder.scene_file, name, warnings):
            materials[material.name] = material
            try:
                if texture_name:
                    encoded = folder.read_path(_portable(texture_name), line, missing_code="IMAGE_MISSING")
                    images.append((material, EncodedImage(encoded, str(folder.scene_file), line)))
            except SceneError as error:
                _raise_or_warn(error, on_missing, warnings)
    for (material, _), pixels in zip(images, decode_images([image for _, image in images], on_missing), strict=True):
        if isinstance(pixels, SceneError):
            _raise_or_warn(pixels, on_missing, warnings)
        else:
            material.base_color_texture = Texture(pixels, name=material.name)
    return materials


def _raise_or_warn(error: SceneError, on_missing: str, warnings: list[str]) -> None:
    if on_missing == "error" or error.code not in (*TOLERATED_CODES, "MATERIALS_MISSING"):
        raise error
    warnings.append(f"left out: {error}")


def _portable(name: str) -> str:
    """Windows exporters write backslashes; the path is checked after this."""
    return name.strip().strip('"').replace("\\", "/")


def _parse_mtl(data: bytes, file: Path, library: str, warnings: list[str]) -> list[tuple[Material, str, str]]:
    """Each material with the file name of its diffuse texture ("" for none) and where that stands."""
    found: list[tuple[Material, str, str]] = []
    for number, words, rest in _lines(data):
        keyword, values, pointer = words[0], words[1:], f"{library} {number}"
        if keyword == "newmtl":
            found.append((Material(name=rest, roughness=1.0, double_sided=True), "", pointer))
        if not found:
            continue
        material, _, _ = found[-1]
        if keyword == "Kd":
            material.base_color = (*_color(values, file, pointer), material.base_color[3])
        elif keyword == "Ke":
            material.emission = _color(values, file, pointer)
        elif keyword in ("d", "Tr"):
            (number_,) = _floats(values[-1:], (1,), file, pointer)
            _set_opacity(material, number_ if keyword == "d" else 1.0 - number_, warnings)
        elif keyword == "map_Kd":
            if rest.startswith("-"):
                _warn_once(warnings, "texture options are ignored")
                rest = words[-1]
            found[-1] = (material, rest, pointer)
    return found


def _color(values: list[str], file: Path, pointer: str) -> tuple[float, float, float]:
    red, green, blue = _floats(values, (3,), file, pointer)
    if min(red, green, blue) < 0.0:
        raise SceneError("colours must not be negative", code="VALUE_NOT_IN_RANGE", file=file, pointer=pointer)
    return red, green, blue


def _set_opacity(material: Material, opacity: float, warnings: list[str]) -> None:
    material.base_color = (*material.base_color[:3], min(max(opacity, 0.0), 1.0))
    if opacity < 1.0:
        material.alpha_cutoff = MASK_CUTOFF
        _warn_once(warnings, f"material {material.name}: opacity is replaced by a mask with cutoff {MASK_CUTOFF}")
