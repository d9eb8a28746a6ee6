"""OBJ, PLY and STL on small files written here: exact expectations, and refusals with their codes."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from softshadows.errors import SceneError
from softshadows.scene.load import load_scene
from softshadows.scene.model import Mesh

CORNERS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def save(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refused(path: Path, **options: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(path, **options)
    assert caught.value.file == str(path)
    return caught.value


def corners_of(mesh: Mesh) -> list:
    return mesh.positions[mesh.triangles].tolist()


# --- OBJ --------------------------------------------------------------------------------------------------------------


def test_obj_polygons_become_fans(tmp_path: Path) -> None:
    scene = load_scene(save(tmp_path, "a.obj", CORNERS + "f 1 2 3 4\n"))
    (node,) = scene.nodes
    assert corners_of(node.mesh) == [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]]
    assert node.mesh.material.double_sided
    assert node.mesh.normals is node.mesh.texcoords is node.mesh.colors is None
    assert scene.name == "a"


def test_obj_relative_indices_count_from_their_own_line(tmp_path: Path) -> None:
    text = CORNERS + "f -4 -3 -2\nv 9 9 9\nv 8 8 8\nf -3 -2 -1\n"
    mesh = load_scene(save(tmp_path, "a.obj", text)).nodes[0].mesh
    assert corners_of(mesh) == [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 0], [9, 9, 9], [8, 8, 8]]]


def test_obj_corners_split_where_normals_or_texcoords_differ(tmp_path: Path) -> None:
    text = CORNERS + "vt 0 0\nvt 1 0.25\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3//1\nf 1/2/2 3//1 4//1\n"
    mesh = load_scene(save(tmp_path, "a.obj", text)).nodes[0].mesh
    assert len(mesh.positions) == 5
    assert mesh.texcoords is not None
    assert mesh.normals is not None
    first, second = mesh.triangles[0, 0], mesh.triangles[1, 0]
    assert mesh.texcoords[0, [first, second]].tolist() == [[0, 1], [1, 0.75]]  # v from the top of the image
    assert mesh.normals[[first, second]].tolist() == [[0, 0, 1], [0, 1, 0]]


def test_obj_vertex_colors_comments_and_continued_lines(tmp_path: Path) -> None:
    text = "v 0 0 0 1 0 0 # red\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\n\nf 1 2 \\\n 3\nl 1 2\nmagic 1\n"
    scene = load_scene(save(tmp_path, "a.obj", text))
    assert scene.nodes[0].mesh.colors is not None
    assert scene.nodes[0].mesh.colors.tolist() == [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]
    assert scene.warnings == ["lines are skipped", "statements 'magic' are ignored"]


def test_obj_materials(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    stream = io.BytesIO()
    Image.fromarray(np.full((1, 1, 3), 7, np.uint8)).save(stream, "PNG")
    save(tmp_path / "maps", "wood oak.png", stream.getvalue())
    save(
        tmp_path,
        "a.mtl",
        "newmtl wood\nKd 0.5 0.25 1\nmap_Kd maps\\wood oak.png\nnewmtl lamp\nKe 3 2 1\nnewmtl glass\nd 0.25\n",
    )
    faces = "usemtl wood\nf 1 2 3\nusemtl lamp\nf 1 3 4\nusemtl wood\nf 2 3 4\n"
    faces += "usemtl glass\nf 1 2 4\nusemtl none\nf 1 2 3\n"
    scene = load_scene(save(tmp_path, "a.obj", "mtllib a.mtl\n" + CORNERS + faces))
    wood, lamp, glass, undefined = (node.mesh.material for node in scene.nodes)
    assert [len(node.mesh.triangles) for node in scene.nodes] == [2, 1, 1, 1]
    assert wood.base_color == (0.5, 0.25, 1.0, 1.0)
    assert wood.base_color_texture is not None
    assert wood.base_color_texture.pixels.tolist() == [[[7, 7, 7, 255]]]
    assert lamp.emission == (3.0, 2.0, 1.0)
    assert (glass.base_color[3], glass.alpha_cutoff) == (0.25, 0.5)
    assert undefined.name == "none"
    assert len(scene.warnings) == 2


@pytest.mark.parametrize(
    ("text", "code", "pointer"),
    [
        ("", "MESH_EMPTY", None),
        (CORNERS, "MESH_EMPTY", None),
        ("v 0 0\n", "OBJ_SYNTAX", "line 1"),
        ("v 0 0 x\n", "OBJ_SYNTAX", "line 1"),
        ("v 0 0 nan\n", "ACCESSOR_INVALID_FLOAT", "line 1"),
        ("\nv 0 0 1e999\n", "ACCESSOR_INVALID_FLOAT", "line 2"),
        (CORNERS + "f 1 2\n", "OBJ_SYNTAX", "line 5"),
        (CORNERS + "f 1 2 x\n", "OBJ_SYNTAX", "line 5"),
        (CORNERS + "f 1 2 3/1/1/1\n", "OBJ_SYNTAX", "line 5"),
        (CORNERS + "f 1 2 0\n", "ACCESSOR_INDEX_OOB", "line 5"),
        (CORNERS + "f 1 2 -5\n", "ACCESSOR_INDEX_OOB", "line 5"),
        (CORNERS + "f 1 \\\n 2 3\nf 1 2 0\n", "ACCESSOR_INDEX_OOB", "line 7"),
        (CORNERS + "f 1 2 5\n", "ACCESSOR_INDEX_OOB", None),
        (CORNERS + "f 1/1 2/1 3/1\n", "ACCESSOR_INDEX_OOB", None),
        ("v 0 0 1e300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "ACCESSOR_INVALID_FLOAT", None),
    ],
)
def test_bad_obj_is_refused(tmp_path: Path, text: str, code: str, pointer: str | None) -> None:
    error = refused(save(tmp_path, "a.obj", text))
    assert (error.code, error.pointer) == (code, pointer)


@pytest.mark.parametrize(
    ("library", "code"),
    [
        ("absent.mtl", "MATERIALS_MISSING"),
        ("../a.mtl", "URI_OUTSIDE_FOLDER"),
        ("..\\a.mtl", "URI_OUTSIDE_FOLDER"),
        ("C:\\a.mtl", "URI_OUTSIDE_FOLDER"),
        ("file:/a.mtl", "URI_SCHEME"),
    ],
)
def test_obj_libraries_that_cannot_be_read(tmp_path: Path, library: str, code: str) -> None:
    path = save(tmp_path, "a.obj", f"mtllib {library}\n{CORNERS}f 1 2 3\n")
    error = refused(path)
    assert (error.code, error.pointer) == (code, "line 1")
    assert code in load_scene(path, on_missing="warn").warnings[0]


# --- PLY --------------------------------------------------------------------------------------------------------------

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)


def ply_header(encoding: str, faces: int = 1, extra: str = "") -> str:
    return (
        f"ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{extra}"
        f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_encodings(tmp_path: Path, encoding: str) -> None:
    order = ">" if "big" in encoding else "<"
    if encoding == "ascii":
        body = b"0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"
    else:
        body = VERTICES.astype(f"{order}f4").tobytes() + struct.pack(f"{order}B4i", 4, 0, 1, 2, 3)
    (node,) = load_scene(save(tmp_path, "a.ply", ply_header(encoding).encode() + body)).nodes
    triangles = node.mesh.positions[node.mesh.triangles]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) / 2
    assert areas.tolist() == [0.5, 0.5]
    assert node.mesh.material.double_sided


def test_ply_normals_and_colors(tmp_path: Path) -> None:
    extra = "".join(f"property float {name}\n" for name in ("nx", "ny", "nz"))
    extra += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    rows = "".join(f"{x:g} {y:g} {z:g} 0 0 1 255 0 188\n" for x, y, z in VERTICES)
    mesh = load_scene(save(tmp_path, "a.ply", ply_header("ascii", 1, extra) + rows + "3 0 1 2\n")).nodes[0].mesh
    assert mesh.normals is not None
    assert mesh.colors is not None
    assert mesh.normals.tolist() == [[0, 0, 1]] * 4
    np.testing.assert_allclose(mesh.colors[0], (1, 0, 0.5029, 1), atol=1e-4)  # sRGB 188 is linear 0.503


@pytest.mark.parametrize(
    ("content", "code"),
    [
        ("", "PLY_HEADER_INVALID"),
        ("ply\nformat ascii 1.0\nend_header\n", "PLY_HEADER_INVALID"),
        (ply_header("ascii", 0), "PLY_TRUNCATED"),
        (ply_header("ascii", 0) + "0 0 0\n" * 4, "MESH_EMPTY"),
        (ply_header("ascii", 10**9) + "0 0 0\n" * 4, "PLY_TRUNCATED"),
        (ply_header("binary_middle_endian") + "0 0 0\n" * 4, "PLY_HEADER_INVALID"),
        (ply_header("ascii").replace("float x", "quad x"), "PLY_HEADER_INVALID"),
        (ply_header("ascii").replace("uchar int", "float int"), "PLY_HEADER_INVALID"),
        (ply_header("ascii") + "0 0 0\n" * 4 + "3 0 1 9\n", "ACCESSOR_INDEX_OOB"),
        (ply_header("ascii") + "0 0 0\n0 x 0\n0 0 0\n0 0 0\n3 0 1 2\n", "FORMAT_INVALID"),
        (ply_header("ascii") + "0 0 nan\n" * 4 + "3 0 1 2\n", "ACCESSOR_INVALID_FLOAT"),
        (
            ply_header("binary_little_endian", 2).encode()
            + VERTICES.tobytes()
            + struct.pack("<B3iB3i", 3, 0, 1, 2, 7, 0, 1, 2),
            "PLY_FACES_UNREADABLE",
        ),
    ],
)
def test_bad_ply_is_refused(tmp_path: Path, content: str | bytes, code: str) -> None:
    assert refused(save(tmp_path, "a.ply", content)).code == code


# --- STL --------------------------------------------------------------------------------------------------------------

FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"


def binary_stl(count: int, declared: int) -> bytes:
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    return b"solid looks like text but is not".ljust(80, b"\0") + struct.pack("<I", declared) + facet * count


@pytest.mark.parametrize("content", [f"solid a\n{FACET}endsolid a\n".encode(), binary_stl(1, 1)])
def test_stl(tmp_path: Path, content: bytes) -> None:
    (node,) = load_scene(save(tmp_path, "a.stl", content)).nodes
    assert corners_of(node.mesh) == [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    assert node.mesh.normals is None
    assert node.mesh.material.double_sided


@pytest.mark.parametrize(
    "content", [b"", b"solid a\nendsolid a\n", binary_stl(1, 2), binary_stl(2, 1), binary_stl(0, 0), b"\0" * 84]
)
def test_bad_stl_is_refused(tmp_path: Path, content: bytes) -> None:
    assert refused(save(tmp_path, "a.stl", content)).code in ("STL_INVALID", "FORMAT_INVALID", "MESH_EMPTY")
