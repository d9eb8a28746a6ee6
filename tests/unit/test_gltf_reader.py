"""The glTF reader on small files written here: every feature with exact expectations, every refusal with its code."""

from __future__ import annotations

import base64
import io
import json
import math
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from softshadows.errors import OptionError, SceneError
from softshadows.scene.lights import DirectionalLight, DiskLight, PointLight, RectLight, SpotLight
from softshadows.scene.load import gltf_compression, load_scene

COMPONENT_TYPES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32)


class Builder:
    """Collects arrays into one buffer and JSON, and writes both as .glb or .gltf."""

    def __init__(self, **root: Any) -> None:
        self.data = b""
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], **root}

    def view(self, data: bytes, **properties: Any) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **properties}
        )
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, view: int | None = None, **properties: Any) -> int:
        values = values.reshape(len(values), -1)
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
        self.json["accessors"].append(
            {
                "bufferView": self.view(values.tobytes()) if view is None else view,
                "componentType": COMPONENT_TYPES[values.dtype.name],
                "count": len(values),
                "type": kind,
                **properties,
            }
        )
        return len(self.json["accessors"]) - 1

    def mesh(self, positions: np.ndarray | int = TRIANGLE, indices: list[int] | None = None, **primitive: Any) -> None:
        """Append a mesh of one primitive and a node that places it."""
        attributes = primitive.pop("attributes", {})
        attributes["POSITION"] = positions if isinstance(positions, int) else self.accessor(positions)
        if indices is not None:
            primitive["indices"] = self.accessor(np.array(indices, np.uint16))
        self.json.setdefault("meshes", []).append({"primitives": [{"attributes": attributes, **primitive}]})
        self.json.setdefault("nodes", []).append({"mesh": len(self.json["meshes"]) - 1})

    def root(self, uri: str | None = None) -> dict[str, Any]:
        if not self.data:
            return self.json
        buffer = {"byteLength": len(self.data)} | ({} if uri is None else {"uri": uri})
        return {**self.json, "buffers": [buffer]}

    def glb(self, folder: Path) -> Path:
        text = json.dumps(self.root()).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self.data:
            binary = self.data + b"\0" * (-len(self.data) % 4)
            chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
        path = folder / "scene.glb"
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        return path


def write_json(folder: Path, root: dict[str, Any]) -> Path:
    path = folder / "scene.gltf"
    path.write_text(json.dumps({"asset": {"version": "2.0"}, **root}))
    return path


def png(pixels: np.ndarray) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def data_uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def refused(path: Path, **options: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(path, **options)
    assert caught.value.file == str(path)
    return caught.value


# --- containers -------------------------------------------------------------------------------------------------------


def test_glb_data_uri_and_external_buffer_give_the_same_mesh(tmp_path: Path) -> None:
    builder = Builder()
    builder.mesh(TRIANGLE, [0, 1, 2])
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "buffer one.bin").write_bytes(builder.data)
    sources = [
        builder.glb(tmp_path),
        write_json(tmp_path, builder.root(data_uri(builder.data))),
    ]
    meshes = [load_scene(path).nodes[0].mesh for path in sources]
    meshes.append(load_scene(write_json(tmp_path, builder.root("folder/buffer%20one.bin"))).nodes[0].mesh)
    for mesh in meshes:
        np.testing.assert_array_equal(mesh.positions, TRIANGLE)
        np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2]])
        assert mesh.triangles.dtype == np.uint32
        assert mesh.normals is mesh.texcoords is mesh.colors is None
        assert mesh.material.base_color == (1.0, 1.0, 1.0, 1.0)
        assert (mesh.material.metallic, mesh.material.roughness) == (1.0, 1.0)


def test_a_file_without_scene_content_is_an_empty_scene(tmp_path: Path) -> None:
    scene = load_scene(write_json(tmp_path, {}))
    assert (scene.nodes, scene.lights, scene.cameras, scene.camera) == ([], [], [], None)
    assert scene.warnings == ["the file's scene places no triangles"]


@pytest.mark.parametrize(
    ("damage", "code"),
    [
        (lambda data: data[:11], "GLB_UNEXPECTED_END_OF_HEADER"),
        (lambda data: b"glTX" + data[4:], "GLB_INVALID_MAGIC"),
        (lambda data: data[:4] + b"\1" + data[5:], "GLB_INVALID_VERSION"),
        (lambda data: data[:-4], "GLB_LENGTH_MISMATCH"),
        (lambda data: data[:8] + struct.pack("<I", 12), "GLB_UNEXPECTED_FIRST_CHUNK"),
        (lambda data: data[:8] + struct.pack("<I", 16) + b"\0\0\0\0", "GLB_UNEXPECTED_END_OF_CHUNK_HEADER"),
        (lambda data: data[:12] + struct.pack("<I", 2**20) + data[16:], "GLB_UNEXPECTED_END_OF_CHUNK_DATA"),
        (lambda data: data[:16] + b"BIN\0" + data[20:], "GLB_UNEXPECTED_FIRST_CHUNK"),
    ],
)
def test_a_damaged_glb_is_refused(tmp_path: Path, damage: Any, code: str) -> None:
    builder = Builder()
    builder.mesh()
    path = builder.glb(tmp_path)
    path.write_bytes(damage(path.read_bytes()))
    assert refused(path).code == code


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "INVALID_JSON"),
        ("[]", "TYPE_MISMATCH"),
        ("[" * 100_000 + "]" * 100_000, "INVALID_JSON"),
        ('{"asset": {"version": "2.0"}, "x": NaN}', "INVALID_JSON"),
        ('{"asset": {"version": "2.0"}, "asset": {"version": "2.0"}}', "INVALID_JSON"),
        ('{"asset": {"version": "2.0"}, "x": ' + "1" * 10_000 + "}", "INVALID_JSON"),
        ('{"asset": {"version": "2.0"}, "scene": true}', "TYPE_MISMATCH"),
        ('{"asset": {"version": "2.0"}, "scene": ' + "1" * 400 + "}", "VALUE_NOT_IN_RANGE"),
        ('{"asset": {"version": "1.0"}}', "UNKNOWN_ASSET_MAJOR_VERSION"),
        ('{"asset": {"version": 2.0}}', "TYPE_MISMATCH"),
        ('{"asset": {}}', "UNDEFINED_PROPERTY"),
        ("{}", "UNDEFINED_PROPERTY"),
        ('{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_x"]}', "UNSUPPORTED_REQUIRED_EXTENSION"),
    ],
)
def test_bad_json_is_refused(tmp_path: Path, text: str, code: str) -> None:
    path = tmp_path / "scene.gltf"
    path.write_text(text)
    assert refused(path).code == code


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert refused(tmp_path / "absent.glb").code == "FILE_MISSING"
    (tmp_path / "folder.glb").mkdir()
    assert refused(tmp_path / "folder.glb").code == "FILE_UNREADABLE"
    unsupported = refused(tmp_path / "scene.fbx")
    assert unsupported.code == "FORMAT_UNSUPPORTED"
    assert ".glb, .gltf, .obj, .ply, .stl" in unsupported.message
    with pytest.raises(OptionError):
        load_scene(tmp_path / "scene.glb", on_missing="ignore")  # type: ignore[arg-type]


def test_unknown_used_extensions_are_named(tmp_path: Path) -> None:
    scene = load_scene(write_json(tmp_path, {"extensionsUsed": ["KHR_materials_clearcoat"]}))
    assert "extension KHR_materials_clearcoat is ignored" in scene.warnings


# --- geometry ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "indices", "triangles"),
    [
        (4, [0, 1, 2, 2, 1, 3], [[0, 1, 2], [2, 1, 3]]),
        (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
        (6, [0, 1, 3, 2], [[1, 3, 0], [3, 2, 0]]),
        (4, None, [[0, 1, 2]]),
        (5, None, [[0, 1, 2], [1, 3, 2]]),
        (4, [0, 0, 0], [[0, 0, 0]]),
    ],
)
def test_triangles_strips_and_fans(tmp_path: Path, mode: int, indices: list[int] | None, triangles: list) -> None:
    builder = Builder()
    builder.mesh(SQUARE, indices, mode=mode)
    mesh = load_scene(builder.glb(tmp_path)).nodes[0].mesh
    np.testing.assert_array_equal(mesh.positions[mesh.triangles], SQUARE[triangles])


def test_points_and_lines_are_skipped_with_a_warning(tmp_path: Path) -> None:
    builder = Builder()
    builder.mesh(mode=0)
    builder.mesh(mode=3)
    scene = load_scene(builder.glb(tmp_path))
    assert scene.nodes == []
    assert "mesh '': points and lines are skipped" in scene.warnings


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32])
def test_index_types(tmp_path: Path, dtype: type) -> None:
    builder = Builder()
    builder.mesh(SQUARE)
    index = builder.accessor(np.array([3, 1, 2], dtype))
    builder.json["meshes"][0]["primitives"][0]["indices"] = index
    mesh = load_scene(builder.glb(tmp_path)).nodes[0].mesh
    np.testing.assert_array_equal(mesh.positions[mesh.triangles][0], SQUARE[[3, 1, 2]])


@pytest.mark.parametrize(
    ("dtype", "normalized", "scale"),
    [
        (np.int8, True, 127),
        (np.uint8, True, 255),
        (np.int16, True, 32767),
        (np.uint16, True, 65535),
        (np.int8, False, 1),
        (np.uint16, False, 1),
    ],
)
def test_quantized_positions(tmp_path: Path, dtype: type, normalized: bool, scale: int) -> None:
    builder = Builder(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"])
    info = np.iinfo(dtype)
    stored = np.array([[info.min, 0, 0], [info.max, 1, 0], [0, 100, 0]], dtype)
    builder.mesh(builder.accessor(stored, normalized=normalized))
    expected = np.maximum(stored.astype(np.float32) / np.float32(scale), -1.0 if normalized else -np.inf)
    np.testing.assert_array_equal(load_scene(builder.glb(tmp_path)).nodes[0].mesh.positions, expected)


def test_interleaved_attributes(tmp_path: Path) -> None:
    normals = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    texcoords = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    builder = Builder()
    view = builder.view(np.hstack([TRIANGLE, normals, texcoords]).astype(np.float32).tobytes(), byteStride=32)
    builder.mesh(
        builder.accessor(TRIANGLE, view),
        attributes={
            "NORMAL": builder.accessor(normals, view, byteOffset=12),
            "TEXCOORD_0": builder.accessor(texcoords, view, byteOffset=24),
        },
    )
    mesh = load_scene(builder.glb(tmp_path)).nodes[0].mesh
    np.testing.assert_array_equal(mesh.positions, TRIANGLE)
    np.testing.assert_array_equal(mesh.normals, normals)
    np.testing.assert_array_equal(mesh.texcoords, [texcoords, np.zeros((3, 2))])


@pytest.mark.parametrize("base", [True, False])
def test_sparse_accessors(tmp_path: Path, base: bool) -> None:
    builder = Builder()
    position = builder.accessor(TRIANGLE)
    accessor = builder.json["accessors"][position]
    accessor["sparse"] = {
        "count": 1,
        "indices": {"bufferView": builder.view(b"\2"), "componentType": 5121},
        "values": {"bufferView": builder.view(np.array([5, 6, 7], np.float32).tobytes())},
    }
    if not base:
        del accessor["bufferView"]
    builder.mesh(position)
    expected = TRIANGLE.copy() if base else np.zeros((3, 3), np.float32)
    expected[2] = (5, 6, 7)
    np.testing.assert_array_equal(load_scene(builder.glb(tmp_path)).nodes[0].mesh.positions, expected)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_vertex_colors(tmp_path: Path, channels: int, dtype: type) -> None:
    colors = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 1]])[:, :channels]
    builder = Builder()
    padded = np.zeros((3, 4), dtype)  # rows of a vertex attribute start at multiples of four bytes
    padded[:, :channels] = colors * (1 if dtype == np.float32 else 255)
    view = builder.view(padded.tobytes(), byteStride=padded.strides[0])
    stored = padded[:, :channels]
    index = builder.accessor(stored, view, normalized=dtype != np.float32)
    builder.mesh(attributes={"COLOR_0": index})
    expected = np.hstack([colors, np.ones((3, 1))]) if channels == 3 else colors
    np.testing.assert_array_equal(load_scene(builder.glb(tmp_path)).nodes[0].mesh.colors, expected)


def test_primitives_that_share_a_big_buffer_keep_only_their_vertices(tmp_path: Path) -> None:
    positions = np.arange(300, dtype=np.float32).reshape(100, 3)
    builder = Builder()
    builder.mesh(positions, [50, 99, 7])
    mesh = load_scene(builder.glb(tmp_path)).nodes[0].mesh
    np.testing.assert_array_equal(mesh.positions[mesh.triangles][0], positions[[50, 99, 7]])
    assert len(mesh.positions) == 3


def test_nodes_that_name_the_same_mesh_share_it(tmp_path: Path) -> None:
    builder = Builder()
    builder.mesh()
    builder.json["nodes"] += [{"mesh": 0, "translation": [x, 0, 0]} for x in range(5000)]
    scene = load_scene(builder.glb(tmp_path))
    assert len(scene.nodes) == 5001
    assert len({id(node.mesh) for node in scene.nodes}) == 1
    assert scene.nodes[4].transform[0, 3] == 3.0


def zeros(count: int) -> dict[str, Any]:
    """An accessor without data: `count` positions at the origin."""
    return {"componentType": 5126, "count": count, "type": "VEC3"}


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda root: root["accessors"][0].update(count=4), "ACCESSOR_TOO_LONG"),
        (lambda root: root["accessors"][0].update(count=2**50), "ACCESSOR_TOO_LONG"),
        (lambda root: root["accessors"][0].update(byteOffset=1), "ACCESSOR_TOO_LONG"),
        (lambda root: root["accessors"][0].update(count=0), "VALUE_NOT_IN_RANGE"),
        (lambda root: root["accessors"][0].update(count=True), "TYPE_MISMATCH"),
        (lambda root: root["accessors"][0].update(componentType=5124), "VALUE_NOT_IN_LIST"),
        (lambda root: root["accessors"][0].update(type="VEC5"), "VALUE_NOT_IN_LIST"),
        (lambda root: root["accessors"][0].update(normalized=True), "ACCESSOR_NORMALIZED_INVALID"),
        (lambda root: root["accessors"].__setitem__(0, zeros(2**40)), "FILE_TOO_BIG"),
        (lambda root: root["accessors"][0].update(bufferView=9), "UNRESOLVED_REFERENCE"),
        (
            lambda root: root["accessors"][1].update(componentType=5120),
            "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
        ),
        (lambda root: root["bufferViews"][0].update(byteLength=2**40), "BUFFER_VIEW_TOO_LONG"),
        (lambda root: root["bufferViews"][0].update(byteStride=4), "ACCESSOR_SMALL_BYTESTRIDE"),
        (lambda root: root["bufferViews"][0].update(buffer=1), "UNRESOLVED_REFERENCE"),
        (lambda root: root["meshes"][0].update(primitives=[]), "EMPTY_ENTITY"),
        (lambda root: root["meshes"][0]["primitives"][0].update(mode=7), "VALUE_NOT_IN_RANGE"),
        (lambda root: root["meshes"][0]["primitives"][0].update(material=0), "UNRESOLVED_REFERENCE"),
        (lambda root: root["meshes"][0]["primitives"][0]["attributes"].update(POSITION=-1), "VALUE_NOT_IN_RANGE"),
        (
            lambda root: root["meshes"][0]["primitives"][0]["attributes"].update(NORMAL=1),
            "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
        ),
        (lambda root: root["nodes"][0].update(mesh=1.5), "TYPE_MISMATCH"),
        (lambda root: root["nodes"][0].update(children=[0]), "NODE_LOOP"),
        (lambda root: root["nodes"][0].update(matrix=[1] * 15), "ARRAY_LENGTH_NOT_IN_LIST"),
        (lambda root: root["nodes"][0].update(scale=[1, "x", 1]), "ARRAY_TYPE_MISMATCH"),
        (lambda root: root["nodes"][0].update(translation=[0, 0, 10**400]), "VALUE_NOT_IN_RANGE"),
        (lambda root: root.update(nodes={}), "TYPE_MISMATCH"),
        (lambda root: root.update(scene=0), "UNRESOLVED_REFERENCE"),
    ],
)
def test_broken_references_and_sizes_are_refused(tmp_path: Path, change: Any, code: str) -> None:
    builder = Builder()
    builder.mesh(TRIANGLE, [0, 1, 2])
    change(builder.json)
    error = refused(builder.glb(tmp_path))
    assert error.code == code
    assert error.pointer is not None
    assert error.pointer.startswith("/")


def test_values_that_are_wrong_only_in_the_data(tmp_path: Path) -> None:
    out_of_range = Builder()
    out_of_range.mesh(TRIANGLE, [0, 1, 3])
    error = refused(out_of_range.glb(tmp_path))
    assert (error.code, error.pointer) == ("ACCESSOR_INDEX_OOB", "/accessors/1")

    restart = Builder()
    restart.mesh(TRIANGLE, [0, 1, 65535])
    assert refused(restart.glb(tmp_path)).code == "ACCESSOR_INDEX_PRIMITIVE_RESTART"

    for bad in (np.nan, np.inf):
        builder = Builder()
        builder.mesh(np.where(TRIANGLE == 1.0, np.float32(bad), TRIANGLE).astype(np.float32))
        assert refused(builder.glb(tmp_path)).code == "ACCESSOR_INVALID_FLOAT"

    unequal = Builder()
    unequal.mesh(TRIANGLE, attributes={"NORMAL": unequal.accessor(SQUARE)})
    assert refused(unequal.glb(tmp_path)).code == "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT"


@pytest.mark.parametrize(
    ("indices", "count", "code"),
    [
        ([1, 1], 2, "ACCESSOR_SPARSE_INDICES_NON_INCREASING"),
        ([1, 3], 2, "ACCESSOR_SPARSE_INDEX_OOB"),
        ([0, 1], 2**40, "VALUE_NOT_IN_RANGE"),
        ([0, 1], 3, "ACCESSOR_TOO_LONG"),
    ],
)
def test_bad_sparse_accessors_are_refused(tmp_path: Path, indices: list[int], count: int, code: str) -> None:
    builder = Builder()
    position = builder.accessor(TRIANGLE)
    builder.json["accessors"][position]["sparse"] = {
        "count": count,
        "indices": {"bufferView": builder.view(bytes(indices)), "componentType": 5121},
        "values": {"bufferView": builder.view(TRIANGLE[:2].tobytes())},
    }
    builder.mesh(position)
    assert refused(builder.glb(tmp_path)).code == code


# --- nodes ------------------------------------------------------------------------------------------------------------


def test_transforms_compose_parent_first(tmp_path: Path) -> None:
    half_turn_z = [0, 0, 1, 0]
    quarter_turn_y = [0, math.sqrt(0.5), 0, math.sqrt(0.5)]
    builder = Builder()
    builder.mesh()
    builder.json["nodes"] = [
        {"children": [1, 2], "translation": [1, 2, 3], "rotation": half_turn_z, "scale": [2, 2, 2]},
        {"mesh": 0, "rotation": quarter_turn_y, "name": "turned"},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1], "name": "mirrored"},
    ]
    turned, mirrored = load_scene(builder.glb(tmp_path)).nodes
    assert (turned.name, mirrored.name) == ("turned", "mirrored")
    np.testing.assert_allclose(turned.transform @ (0, 0, 1, 1), (1 - 2, 2, 3, 1), atol=1e-12)
    np.testing.assert_allclose(turned.transform @ (0, 1, 0, 1), (1, 2 - 2, 3, 1), atol=1e-12)
    np.testing.assert_allclose(mirrored.transform @ (1, 0, 0, 1), (1 - 2 * 9, 2, 3, 1), atol=1e-12)
    assert np.linalg.det(mirrored.transform[:3, :3]) == pytest.approx(-8.0)


def test_only_the_default_scene_is_loaded(tmp_path: Path) -> None:
    builder = Builder(scene=1, scenes=[{"nodes": [0]}, {"nodes": [1]}])
    builder.mesh()
    builder.mesh()
    builder.json["nodes"][1]["name"] = "second"
    assert [node.name for node in load_scene(builder.glb(tmp_path)).nodes] == ["second"]


@pytest.mark.parametrize(
    ("nodes", "scenes", "code"),
    [
        ([{"children": [1]}, {"children": [0]}], [], "NODE_LOOP"),
        ([{"children": [2]}, {"children": [2]}, {}], [], "NODE_PARENT_OVERRIDE"),
        ([{"children": [1, 1]}, {}], [], "NODE_PARENT_OVERRIDE"),
        ([{"children": [7]}], [], "UNRESOLVED_REFERENCE"),
        ([{"children": [1]}, {}], [{"nodes": [1]}], "SCENE_NON_ROOT_NODE"),
        ([{}], [{"nodes": [0, 0]}], "DUPLICATE_ELEMENTS"),
        ([{"rotation": [0, 0, 0, 0]}], [], "ROTATION_NON_UNIT"),
        ([{"matrix": [1] * 16, "scale": [1, 1, 1]}], [], "NODE_MATRIX_TRS"),
        ([{"matrix": [1] * 16}], [], "NODE_MATRIX_NON_TRS"),
        ([{"scale": [1e300] * 3, "children": [1]}, {"scale": [1e300] * 3}], [], "NODE_MATRIX_INVALID"),
    ],
)
def test_bad_hierarchies_are_refused(tmp_path: Path, nodes: list, scenes: list, code: str) -> None:
    assert refused(write_json(tmp_path, {"nodes": nodes, "scenes": scenes})).code == code


def test_a_hierarchy_100000_deep_loads(tmp_path: Path) -> None:
    depth = 100_000
    builder = Builder()
    builder.mesh()
    chain: list[dict[str, Any]] = [{"children": [i + 1], "translation": [0, 0, 1]} for i in range(depth)]
    builder.json["nodes"] = [*chain, {"mesh": 0}]
    (node,) = load_scene(builder.glb(tmp_path)).nodes
    assert node.transform[2, 3] == depth


# --- materials --------------------------------------------------------------------------------------------------------


def material_of(folder: Path, material: dict[str, Any], **root: Any) -> Any:
    builder = Builder(materials=[material], **root)
    builder.mesh(material=0)
    scene = load_scene(builder.glb(folder))
    return scene.nodes[0].mesh.material, scene.warnings


def test_factors(tmp_path: Path) -> None:
    material, warnings = material_of(
        tmp_path,
        {
            "name": "brass",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 0.125, 0.75],
                "metallicFactor": 0.5,
                "roughnessFactor": 0.25,
            },
            "emissiveFactor": [1, 0.5, 0],
            "doubleSided": True,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
        },
    )
    assert material.name == "brass"
    assert material.base_color == (0.5, 0.25, 0.125, 0.75)
    assert (material.metallic, material.roughness, material.double_sided) == (0.5, 0.25, True)
    assert material.emission == (8.0, 4.0, 0.0)
    assert material.alpha_cutoff is None
    assert warnings == []


@pytest.mark.parametrize(
    ("properties", "cutoff", "warned"),
    [
        ({"alphaMode": "MASK"}, 0.5, 0),
        ({"alphaMode": "MASK", "alphaCutoff": 0.25}, 0.25, 0),
        ({"alphaMode": "BLEND"}, 0.5, 1),
        ({"alphaMode": "OPAQUE", "alphaCutoff": 0.25}, None, 0),
        ({"extensions": {"KHR_materials_unlit": {}}}, None, 1),
    ],
)
def test_alpha_modes_and_unlit(tmp_path: Path, properties: dict, cutoff: float | None, warned: int) -> None:
    material, warnings = material_of(tmp_path, properties)
    assert material.alpha_cutoff == cutoff
    assert len(warnings) == warned


@pytest.mark.parametrize(
    ("properties", "code"),
    [
        ({"alphaMode": "GLOW"}, "VALUE_NOT_IN_LIST"),
        ({"alphaCutoff": -1}, "VALUE_NOT_IN_RANGE"),
        ({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 2, 1]}}, "VALUE_NOT_IN_RANGE"),
        ({"pbrMetallicRoughness": {"metallicFactor": "1"}}, "TYPE_MISMATCH"),
        ({"emissiveTexture": {"index": 0}}, "UNRESOLVED_REFERENCE"),
        ({"normalTexture": {"index": 0}}, "UNRESOLVED_REFERENCE"),
        ({"doubleSided": 1}, "TYPE_MISMATCH"),
    ],
)
def test_bad_materials_are_refused(tmp_path: Path, properties: dict, code: str) -> None:
    builder = Builder(materials=[properties])
    builder.mesh(material=0)
    assert refused(builder.glb(tmp_path)).code == code


def textured(uri: str, info: dict[str, Any] | None = None, sampler: dict[str, Any] | None = None) -> Builder:
    """A triangle whose base colour texture is the image at `uri`."""
    builder = Builder(
        images=[{"uri": uri}],
        samplers=[sampler or {}],
        textures=[{"source": 0, "sampler": 0, "name": "paint"}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **(info or {})}}}],
    )
    builder.mesh(material=0)
    return builder


def texture_of(path: Path) -> Any:
    return load_scene(path).nodes[0].mesh.material.base_color_texture


@pytest.mark.parametrize(
    ("stored", "expected"),
    [
        (np.array([[[1, 2, 3, 4]]], np.uint8), [1, 2, 3, 4]),
        (np.array([[[1, 2, 3]]], np.uint8), [1, 2, 3, 255]),
        (np.array([[7]], np.uint8), [7, 7, 7, 255]),
        (np.array([[7 * 256 + 9]], np.uint16), [7, 7, 7, 255]),
    ],
)
def test_image_formats(tmp_path: Path, stored: np.ndarray, expected: list[int]) -> None:
    pixels = texture_of(textured(data_uri(png(stored))).glb(tmp_path)).pixels
    assert pixels.dtype == np.uint8
    assert pixels.shape == (1, 1, 4)
    np.testing.assert_array_equal(pixels[0, 0], expected)


def test_sampler_transform_and_coordinate_set(tmp_path: Path) -> None:
    uri = data_uri(png(np.zeros((2, 3, 4), np.uint8)))
    transform = {"offset": [0, 1], "rotation": math.pi / 2, "scale": [0.5, 0.5], "texCoord": 1}
    info = {"texCoord": 0, "extensions": {"KHR_texture_transform": transform}}
    builder = textured(uri, info, {"wrapS": 33071, "wrapT": 33648, "magFilter": 9728})
    texture = texture_of(builder.glb(tmp_path))
    assert texture.pixels.shape == (2, 3, 4)
    assert (texture.wrap_u, texture.wrap_v, texture.nearest, texture.texcoord) == ("clamp", "mirror", True, 1)
    assert texture.name == "paint"
    # The extension's own example: the lower left quadrant (v points down), turned by a quarter.
    corners = texture.transform @ np.array([[0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 1, 1]])
    np.testing.assert_allclose(corners, [[0, 0, 0.5, 0.5], [1, 0.5, 1, 0.5]], atol=1e-7)


def test_textures_share_images_and_external_files_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png(np.full((1, 1, 3), 9, np.uint8)))
    builder = textured("a.png")
    builder.json["images"].append({"uri": "a.png"})
    builder.json["textures"].append({"source": 1})
    builder.json["materials"][0]["emissiveTexture"] = {"index": 1}
    material = load_scene(builder.glb(tmp_path)).nodes[0].mesh.material
    assert material.base_color_texture.pixels is material.emission_texture.pixels
    assert material.emission_texture.wrap_u == "repeat"


def test_images_in_buffer_views(tmp_path: Path) -> None:
    builder = textured("")
    view = builder.view(png(np.full((1, 1, 3), 9, np.uint8)))
    builder.json["images"] = [{"bufferView": view, "mimeType": "image/png"}]
    assert texture_of(builder.glb(tmp_path)).pixels.tolist() == [[[9, 9, 9, 255]]]


def bomb() -> bytes:
    """A PNG whose header declares 2^30 pixels."""
    small = png(np.zeros((1, 1, 3), np.uint8))
    header = b"IHDR" + struct.pack(">II", 32768, 32768) + small[24:29]
    return small[:12] + header + struct.pack(">I", zlib.crc32(header)) + small[33:]


@pytest.mark.parametrize(
    ("uri", "code"),
    [
        ("absent.png", "IMAGE_MISSING"),
        (data_uri(b"not an image"), "IMAGE_INVALID"),
        (data_uri(png(np.zeros((64, 64, 3), np.uint8))[:60]), "IMAGE_INVALID"),
        (data_uri(bomb()), "IMAGE_TOO_BIG"),
        ("../outside.png", "URI_OUTSIDE_FOLDER"),
    ],
)
def test_images_that_cannot_be_read(tmp_path: Path, uri: str, code: str) -> None:
    path = textured(uri).glb(tmp_path)
    error = refused(path)
    assert (error.code, error.pointer) == (code, "/images/0/uri")
    scene = load_scene(path, on_missing="warn")
    assert scene.nodes[0].mesh.material.base_color_texture is None
    assert code in scene.warnings[0]


# --- lights and cameras -----------------------------------------------------------------------------------------------

LOOK_DOWN = [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]


def light_scene(folder: Path, extension: str, light: dict[str, Any], **node: Any) -> Any:
    root = {
        "extensionsUsed": [extension],
        "extensions": {extension: {"lights": [light]}},
        "nodes": [{"extensions": {extension: {"light": 0}}, **node}],
    }
    return load_scene(write_json(folder, root))


def test_punctual_lights(tmp_path: Path) -> None:
    name = "KHR_lights_punctual"
    node = {"translation": [1, 2, 3], "rotation": LOOK_DOWN}
    shade = {"color": [1, 0.5, 0], "intensity": 10}
    (point,) = light_scene(tmp_path, name, {"type": "point", **shade}, **node).lights
    assert point == PointLight((1, 2, 3), (10, 5, 0))
    (sun,) = light_scene(tmp_path, name, {"type": "directional", **shade}, **node).lights
    assert isinstance(sun, DirectionalLight)
    np.testing.assert_allclose(sun.direction, (0, -1, 0), atol=1e-15)
    assert sun.irradiance == (10, 5, 0)
    cone = {"innerConeAngle": 0.1, "outerConeAngle": 0.2}
    (spot,) = light_scene(tmp_path, name, {"type": "spot", "spot": cone, **shade}, **node).lights
    assert isinstance(spot, SpotLight)
    assert (spot.inner_angle, spot.outer_angle) == (math.degrees(0.1), math.degrees(0.2))
    np.testing.assert_allclose(spot.axes[2], (0, 1, 0), atol=1e-15)


def test_area_lights(tmp_path: Path) -> None:
    name = "EXT_lights_area"
    node = {"translation": [0, 4, 0], "rotation": LOOK_DOWN, "scale": [1, -3, 2]}
    light = {"type": "rect", "size": 2, "rect": {"aspect": 1.5}, "color": [1, 0.5, 0], "intensity": 10}
    (rect,) = light_scene(tmp_path, name, light, **node).lights
    assert isinstance(rect, RectLight)
    assert (rect.width, rect.height) == pytest.approx((9.0, 6.0))
    assert rect.radiance == (10, 5, 0)
    assert rect.one_sided
    np.testing.assert_allclose(rect.axes[2], (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(np.abs(rect.axes[0]), (1, 0, 0), atol=1e-12)
    (disk,) = light_scene(tmp_path, name, {"type": "disk", "size": 2}, **node).lights
    assert isinstance(disk, DiskLight)
    assert disk.radius == pytest.approx(3.0)
    assert disk.radiance == (1000, 1000, 1000)


def test_lights_and_cameras_on_nodes_scaled_to_zero_are_skipped(tmp_path: Path) -> None:
    scene = light_scene(tmp_path, "EXT_lights_area", {"type": "rect"}, scale=[1, 1, 0], name="flat")
    assert scene.lights == []
    assert "node 'flat': a light or camera on a node scaled to zero is skipped" in scene.warnings


@pytest.mark.parametrize(
    ("extension", "light", "code"),
    [
        ("KHR_lights_punctual", {"type": "sphere"}, "VALUE_NOT_IN_LIST"),
        ("KHR_lights_punctual", {"type": "point", "intensity": -1}, "VALUE_NOT_IN_RANGE"),
        ("KHR_lights_punctual", {"type": "point", "intensity": 1e300}, "VALUE_NOT_FINITE"),
        ("KHR_lights_punctual", {"type": "spot"}, "UNDEFINED_PROPERTY"),
        (
            "KHR_lights_punctual",
            {"type": "spot", "spot": {"innerConeAngle": 1}},
            "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES",
        ),
        ("EXT_lights_area", {"type": "rect", "size": -1}, "VALUE_NOT_IN_RANGE"),
        ("EXT_lights_area", {"type": "rect", "size": 1e300}, "VALUE_NOT_IN_RANGE"),
        ("EXT_lights_area", {"type": "tube"}, "VALUE_NOT_IN_LIST"),
    ],
)
def test_bad_lights_are_refused(tmp_path: Path, extension: str, light: dict[str, Any], code: str) -> None:
    with pytest.raises(SceneError) as caught:
        light_scene(tmp_path, extension, light)
    assert caught.value.code == code
    assert f"/extensions/{extension}/lights/0" in (caught.value.pointer or "")


def test_cameras(tmp_path: Path) -> None:
    root = {
        "cameras": [
            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}},
            {"type": "perspective", "perspective": {"yfov": math.pi / 3, "znear": 0.1}},
        ],
        "nodes": [{"camera": 0}, {"camera": 1, "translation": [0, 5, 0], "rotation": LOOK_DOWN}, {"camera": 1}],
    }
    scene = load_scene(write_json(tmp_path, root))
    assert len(scene.cameras) == 2
    assert scene.camera is scene.cameras[0]
    assert scene.camera is not None
    assert scene.camera.vertical_fov == pytest.approx(60.0)
    np.testing.assert_allclose(scene.camera.axes, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)
    assert "orthographic cameras are skipped" in scene.warnings


@pytest.mark.parametrize(
    ("lens", "code"),
    [
        ({"yfov": 0, "znear": 1}, "VALUE_NOT_IN_RANGE"),
        ({"yfov": 4, "znear": 1}, "VALUE_NOT_IN_RANGE"),
        ({"yfov": 1, "znear": 1, "zfar": 1}, "CAMERA_ZFAR_LEQUAL_ZNEAR"),
        ({"yfov": 1}, "UNDEFINED_PROPERTY"),
    ],
)
def test_bad_cameras_are_refused(tmp_path: Path, lens: dict[str, Any], code: str) -> None:
    root = {"cameras": [{"type": "perspective", "perspective": lens}], "nodes": [{"camera": 0}]}
    assert refused(write_json(tmp_path, root)).code == code


def test_skins_animations_and_morph_targets_are_named(tmp_path: Path) -> None:
    builder = Builder(skins=[{"joints": [0]}], animations=[{}])
    builder.mesh(targets=[{"POSITION": 0}])
    assert load_scene(builder.glb(tmp_path)).warnings == [
        "skins are ignored: meshes keep their bind pose",
        "animations are ignored",
        "morph targets are ignored: meshes keep their base shape",
    ]


# --- compression ------------------------------------------------------------------------------------------------------


def grid(side: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Positions and triangles of a square grid with a bump."""
    y, x = np.mgrid[0:side, 0:side]
    positions = np.stack([x, y, np.sin(x) * np.cos(y)], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (y[:-1, :-1] * side + x[:-1, :-1]).reshape(-1)
    return positions, np.concatenate(
        [np.stack([corner, corner + 1, corner + side], 1), np.stack([corner + 1, corner + side + 1, corner + side], 1)]
    ).astype(np.uint32)


def draco_file(folder: Path, encoder: Any = None, **counts: int) -> tuple[Path, np.ndarray, np.ndarray]:
    draco = pytest.importorskip("DracoPy")
    positions, triangles = grid()
    stream = (encoder or draco.encode)(positions, triangles, quantization_bits=14, preserve_order=True)
    builder = Builder(extensionsUsed=["KHR_draco_mesh_compression"], extensionsRequired=["KHR_draco_mesh_compression"])
    view = builder.view(stream)
    builder.json["accessors"] = [
        {"componentType": 5126, "count": counts.get("vertices", len(positions)), "type": "VEC3"},
        {"componentType": 5123, "count": counts.get("indices", triangles.size), "type": "SCALAR"},
    ]
    extension = {"bufferView": view, "attributes": {"POSITION": 0}}
    builder.mesh(0, extensions={"KHR_draco_mesh_compression": extension})
    builder.json["meshes"][0]["primitives"][0]["indices"] = 1
    return builder.glb(folder), positions, triangles


def test_draco(tmp_path: Path) -> None:
    path, positions, triangles = draco_file(tmp_path)
    mesh = load_scene(path).nodes[0].mesh
    np.testing.assert_allclose(mesh.positions[mesh.triangles], positions[triangles], atol=2e-3)


def test_draco_by_edgebreaker(tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy")

    def encode(points: np.ndarray, faces: np.ndarray, **_: Any) -> bytes:
        return draco.encode(points, faces, quantization_bits=14, compression_level=7)

    path, positions, triangles = draco_file(tmp_path, encode)
    mesh = load_scene(path).nodes[0].mesh
    found = np.sort(mesh.positions[mesh.triangles].mean(axis=1), axis=0)
    np.testing.assert_allclose(found, np.sort(positions[triangles].mean(axis=1), axis=0), atol=2e-3)


@pytest.mark.parametrize("counts", [{"vertices": 5}, {"indices": 6}, {"indices": 2**40}])
def test_draco_counts_must_agree(tmp_path: Path, counts: dict[str, int]) -> None:
    assert refused(draco_file(tmp_path, **counts)[0]).code in ("DRACO_COUNT_MISMATCH", "FILE_TOO_BIG")


def test_a_draco_stream_that_declares_too_much_is_refused_before_decoding(tmp_path: Path) -> None:
    def encode(*_: Any, **__: Any) -> bytes:
        return b"DRACO\2\2\1\1\0\0\0" + b"\xff\xff\xff\xff\x0f" * 2 + bytes(100)

    assert refused(draco_file(tmp_path, encode)[0]).code == "DRACO_COUNT_MISMATCH"


def test_a_missing_decoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, _, _ = draco_file(tmp_path)
    monkeypatch.setattr(gltf_compression.importlib, "import_module", _no_module)
    error = refused(path)
    assert error.code == "DECODER_MISSING"
    assert "pip install softshadows[draco]" in error.message


def _no_module(name: str) -> None:
    raise ModuleNotFoundError(name)


def meshopt_file(folder: Path, **changes: Any) -> tuple[Path, np.ndarray, np.ndarray]:
    meshopt = pytest.importorskip("meshoptimizer")
    positions, triangles = grid()
    padded = np.zeros((len(positions), 4), np.float32)
    padded[:, :3] = positions
    vertex_stream = meshopt.encode_vertex_buffer(padded)
    index_stream = meshopt.encode_index_buffer(triangles.reshape(-1))
    name = "EXT_meshopt_compression"
    builder = Builder(extensionsUsed=[name], extensionsRequired=[name])
    views = []
    for stream, count, stride, mode in (
        (vertex_stream, len(positions), 16, "ATTRIBUTES"),
        (index_stream, triangles.size, 2, "TRIANGLES"),
    ):
        offset = len(builder.data)
        builder.data += stream + b"\0" * (-len(stream) % 4)
        compression = {"buffer": 0, "byteOffset": offset, "byteLength": len(stream)}
        compression |= {"byteStride": stride, "count": count, "mode": mode, **changes}
        views.append({"buffer": 1, "byteLength": count * stride, "extensions": {name: compression}})
    views[0]["byteStride"] = 16
    fallback = sum(view["byteLength"] for view in views)
    views[1]["byteOffset"] = views[0]["byteLength"]
    builder.json["bufferViews"] = views
    builder.json["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": triangles.size, "type": "SCALAR"},
    ]
    builder.mesh(0)
    builder.json["meshes"][0]["primitives"][0]["indices"] = 1
    root = builder.root(data_uri(builder.data))
    root["buffers"].append({"byteLength": fallback, "extensions": {name: {"fallback": True}}})
    return write_json(folder, root), positions, triangles


def test_meshopt(tmp_path: Path) -> None:
    path, positions, triangles = meshopt_file(tmp_path)
    mesh = load_scene(path).nodes[0].mesh
    np.testing.assert_array_equal(mesh.positions, positions)
    found = {tuple(np.roll(t, -int(t.argmin()))) for t in mesh.triangles}  # the codec may rotate corners
    assert found == {tuple(np.roll(t, -int(t.argmin()))) for t in triangles}


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"count": 2**40}, "MESHOPT_LENGTH_MISMATCH"),
        ({"mode": "POINTS"}, "VALUE_NOT_IN_LIST"),
        ({"filter": "OCTAHEDRAL"}, "VALUE_NOT_IN_LIST"),
        ({"byteLength": 20}, "MESHOPT_INVALID_STREAM"),
        ({"byteLength": 2**40}, "BUFFER_VIEW_TOO_LONG"),
        ({"buffer": 1}, "BUFFER_MISSING"),
    ],
)
def test_bad_meshopt_is_refused(tmp_path: Path, changes: dict[str, Any], code: str) -> None:
    assert refused(meshopt_file(tmp_path, **changes)[0]).code == code
