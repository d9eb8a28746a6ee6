"""PLY and STL to Scene through trimesh, after a check that the header does not promise more than the file holds.

trimesh forgives much, so what it returns is compared with what the header declares; whatever it raises becomes
SceneError.
"""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.load.files import read_scene_file
from softshadows.scene.model import Material, Mesh, Node, Scene

PLY_TYPES = {
    **{"char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2, "float16": 2},
    **{"int": 4, "uint": 4, "float": 4, "int32": 4, "uint32": 4, "float32": 4},
    **{"double": 8, "int64": 8, "uint64": 8, "float64": 8},
}
"""Bytes of each PLY scalar type."""

MAX_PLY_HEADER = 2**20
STL_HEADER, STL_TRIANGLE = 84, 50
CORNERS = ("vertex_indices", "vertex_index")


@dataclass
class _PlyElement:
    """`element <name> <count>`: its scalar properties, its list properties, and the fewest bytes one element takes."""

    name: str
    count: int
    scalars: list[str]
    lists: list[str]
    fewest_bytes: int = 0


def load_ply(path: Path, on_missing: str) -> Scene:
    """Read a .ply file: polygons with vertex normals and colours. Raises SceneError.

    In binary files all polygons must have the same number of corners, a limit of trimesh.
    """
    data = read_scene_file(path)
    elements = _check_ply(data, path)
    loaded = _through_trimesh(data, "ply", path)
    mesh = _mesh(loaded, path)
    if len(loaded.faces) < elements["face"].count or not _corner_counts_agree(loaded):
        message = f"the header declares {elements['face'].count} faces, not all could be read"
        raise SceneError(message, code="PLY_FACES_UNREADABLE", file=path)
    if {"nx", "ny", "nz"} <= set(elements["vertex"].scalars):
        columns = loaded.metadata["_ply_raw"]["vertex"]["data"]  # trimesh drops the normals it has read
        normals = np.column_stack([columns[name] for name in ("nx", "ny", "nz")])
        mesh.normals = np.nan_to_num(normals.astype(np.float32), posinf=0.0, neginf=0.0)
    return Scene(nodes=[Node(mesh, name=path.stem)], name=path.stem)


def _corner_counts_agree(loaded: Any) -> bool:
    """trimesh reads every binary polygon as if it had as many corners as the first; False where one says otherwise."""
    faces = loaded.metadata["_ply_raw"]["face"]["data"]
    if not isinstance(faces, np.ndarray) or faces.dtype.names is None:
        return True  # an ASCII file, read line by line
    lists = [faces[name]["f0"] for name in faces.dtype.names if name in CORNERS]
    return all((counts == counts[0]).all() for counts in lists)


def load_stl(path: Path, on_missing: str) -> Scene:
    """Read an .stl file, ASCII or binary; facets are flat. Raises SceneError."""
    data = read_scene_file(path)
    _check_stl(data, path)
    mesh = _mesh(_through_trimesh(data, "stl", path), path)
    return Scene(nodes=[Node(mesh, name=path.stem)], name=path.stem)


def _through_trimesh(data: bytes, file_type: str, path: Path) -> Any:
    """The trimesh.Trimesh that `data` holds. Nothing else is read: a byte stream has no folder to find names in."""
    import trimesh  # slow to import, and most scenes are glTF

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # numpy warns where it stops reading at text that is not a number
            warnings.filterwarnings("ignore", message=".*fromstring.*binary mode.*")
            return trimesh.load_mesh(
                io.BytesIO(data), file_type=file_type, process=False, skip_materials=True, fix_texture=False
            )
    except Exception as error:  # trimesh's readers raise whatever class the accident of the data calls for
        raise SceneError(f"not a readable file: {str(error)[:200]}", code="FORMAT_INVALID", file=path) from None


def _mesh(loaded: Any, path: Path) -> Mesh:
    faces, vertices = getattr(loaded, "faces", None), getattr(loaded, "vertices", None)
    if faces is None or vertices is None or not len(faces):
        raise SceneError("the file has no faces", code="MESH_EMPTY", file=path)
    colors = loaded.visual.vertex_colors if loaded.visual.kind == "vertex" else None
    with np.errstate(over="ignore"):
        return Mesh(
            positions=np.asarray(vertices, np.float32),
            triangles=np.asarray(faces),
            colors=None if colors is None else _linear(np.asarray(colors)),
            material=Material(name=path.stem, double_sided=True),
            name=path.stem,
        )


def _linear(colors: np.ndarray) -> np.ndarray:
    """(n, 4) uint8 colours, which scanners and modellers write in sRGB, as linear float32; alpha stays."""
    encoded = colors.astype(np.float32) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return np.concatenate([linear[:, :3], encoded[:, 3:]], axis=1).astype(np.float32)


def _check_ply(data: bytes, path: Path) -> dict[str, _PlyElement]:
    """The elements that a strictly read header declares; they fit into the file, and there are positions and faces."""

    def error(code: str, message: str, line: int | None = None) -> SceneError:
        return SceneError(message, code=code, file=path, pointer=None if line is None else f"line {line}")

    end = re.search(rb"(?:^|\n)end_header\r?\n", data[:MAX_PLY_HEADER])
    if not data.startswith((b"ply\n", b"ply\r\n")) or end is None:
        raise error("PLY_HEADER_INVALID", "a PLY file starts with 'ply' and has a header that ends with 'end_header'")
    elements: dict[str, _PlyElement] = {}
    encoding = ""
    for number, line in enumerate(data[: end.start()].decode("latin-1").splitlines()[1:], start=2):
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        if words[0] == "format" and len(words) == 3 and not elements and not encoding:
            encoding = words[1]
        elif words[0] == "element" and len(words) == 3 and re.fullmatch(r"[0-9]{1,12}", words[2]) and encoding:
            if words[1] in elements:
                raise error("PLY_HEADER_INVALID", f"element {words[1]!r} is declared twice", number)
            elements[words[1]] = _PlyElement(words[1], int(words[2]), [], [])
        elif words[0] == "property" and elements:
            _add_property(list(elements.values())[-1], words, number, path)
        else:
            raise error("PLY_HEADER_INVALID", f"not a PLY header line: {line[:60]!r}", number)
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise error("PLY_HEADER_INVALID", "the format must be ascii, binary_little_endian or binary_big_endian")

    body = len(data) - end.end()
    fewest = sum(
        element.count * (element.fewest_bytes if encoding != "ascii" else 2 * len(element.scalars + element.lists))
        for element in elements.values()
    )
    if fewest > body + 1:  # the last ASCII number may end without a separator
        raise error("PLY_TRUNCATED", f"the header declares at least {fewest} bytes of data, the file has {body}")
    vertex, face = elements.get("vertex"), elements.get("face")
    if vertex is None or not {"x", "y", "z"} <= set(vertex.scalars):
        raise error("PLY_HEADER_INVALID", "a mesh needs vertices with properties x, y and z")
    if face is None or not face.count or not any(name in face.lists for name in CORNERS):
        raise error("MESH_EMPTY", "the file has no faces with a property list vertex_indices")
    return elements


def _add_property(element: _PlyElement, words: list[str], number: int, path: Path) -> None:
    is_list = len(words) == 5 and words[1] == "list"
    types = words[2:4] if is_list else words[1:2]
    name = words[-1]
    if (not is_list and len(words) != 3) or any(kind not in PLY_TYPES for kind in types):
        message = f"not a PLY property: {' '.join(words)[:60]!r}"
        raise SceneError(message, code="PLY_HEADER_INVALID", file=path, pointer=f"line {number}")
    if name in element.scalars or name in element.lists:
        message = f"property {name!r} is declared twice"
        raise SceneError(message, code="PLY_HEADER_INVALID", file=path, pointer=f"line {number}")
    if is_list and ("float" in types[0] or "double" in types[0]):
        message = "the length of a list must be an integer"
        raise SceneError(message, code="PLY_HEADER_INVALID", file=path, pointer=f"line {number}")
    (element.lists if is_list else element.scalars).append(name)
    element.fewest_bytes += PLY_TYPES[types[0]]


def _check_stl(data: bytes, path: Path) -> None:
    """Binary STL must be as long as its triangle count says; ASCII STL must start with `solid` and have facets."""
    if len(data) >= STL_HEADER:
        count = int.from_bytes(data[80:84], "little")
        if len(data) == STL_HEADER + count * STL_TRIANGLE:
            return
    if data.lstrip()[:5].lower() != b"solid" or b"facet" not in data.lower():
        message = "neither an ASCII STL file nor a binary one of the length that its header declares"
        raise SceneError(message, code="STL_INVALID", file=path)
