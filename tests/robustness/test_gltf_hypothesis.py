"""Mutated glTF files: only SceneError may escape, and no file outside the asset's folder is ever opened."""

from __future__ import annotations

import base64
import copy
import io
import json
import os
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from softshadows.errors import SceneError
from softshadows.scene.load import load_scene

RELAXED = settings(
    max_examples=400, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def _document() -> tuple[dict[str, Any], bytes]:
    """A valid file that uses most of what the reader reads, as JSON and buffer."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32)
    texcoords = positions[:, :2].copy()
    indices = np.array([0, 1, 2, 2, 1, 3], np.uint16)
    stream = io.BytesIO()
    Image.fromarray(np.zeros((2, 2, 4), np.uint8)).save(stream, "PNG")
    blocks = [positions.tobytes(), texcoords.tobytes(), indices.tobytes(), b"\1\0\0\0", positions[:1].tobytes()]
    blocks.append(stream.getvalue())
    views, data = [], b""
    for block in blocks:
        data += b"\0" * (-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(block)})
        data += block
    sparse = {"count": 1, "indices": {"bufferView": 3, "componentType": 5121}, "values": {"bufferView": 4}}
    texture = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 0.5}}}
    extensions = {
        "KHR_lights_punctual": {
            "lights": [
                {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
                {"type": "directional", "color": [1, 0, 0]},
            ]
        },
        "EXT_lights_area": {"lights": [{"type": "rect", "size": 1, "rect": {"aspect": 2}}, {"type": "disk"}]},
    }
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": list(extensions),
        "extensions": extensions,
        "scene": 0,
        "scenes": [{"nodes": [0, 3]}],
        "nodes": [
            {"children": [1, 2], "translation": [0, 1, 0], "rotation": [0, 0, 0, 1], "scale": [1, 2, -1]},
            {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}, "EXT_lights_area": {"light": 0}}},
            {"mesh": 0, "camera": 0, "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"matrix": np.eye(4).reshape(-1).tolist(), "extensions": {"EXT_lights_area": {"light": 1}}},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "zfar": 10}}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0},
                    {"attributes": {"POSITION": 0}, "mode": 5},
                ]
            }
        ],
        "materials": [
            {
                "pbrMetallicRoughness": {"baseColorTexture": texture, "baseColorFactor": [1, 1, 1, 1]},
                "emissiveFactor": [1, 1, 1],
                "alphaMode": "MASK",
                "alphaCutoff": 0.5,
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}},
            }
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "magFilter": 9728}],
        "images": [{"bufferView": 5, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    return document, data


DOCUMENT, DATA = _document()


def glb(document: dict[str, Any], data: bytes) -> bytes:
    text = json.dumps(document).encode("utf-8", "surrogatepass")
    text, data = text + b" " * (-len(text) % 4), data + b"\0" * (-len(data) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def load_bytes(folder: Path, data: bytes, name: str = "scene.glb") -> None:
    """Load `data`; only a SceneError with a real code may escape."""
    path = folder / name
    path.write_bytes(data)
    error = refusal(path)
    assert error is None or error.code not in (None, "READER_FAILED"), error


def refusal(path: Path) -> SceneError | None:
    """The SceneError that loading `path` raises, None where it loads. Anything else escapes and fails the test."""
    try:
        load_scene(path)
    except SceneError as error:
        return error
    return None


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of every value in a JSON document."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in items:
        yield from places(child, (*path, key))


PLACES = [place for place in places(DOCUMENT) if place]
LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 8),
    st.sampled_from([2**31, 2**32, 2**53, 2**63, 2**64, 10**400, -(10**30), 5120, 5121, 5122, 5125, 5126]),
    st.floats(allow_nan=False),
    st.sampled_from([1e-320, 1e38, 3.4e38, 1e308, -0.0]),
    st.text(max_size=6),
    st.sampled_from(["../x", "/etc/passwd", "data:,", "data:;base64,A", "BLEND", "VEC4", "MAT4", "\ud800", "file:x"]),
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=4), inner, max_size=3)),
)


def test_the_document_itself_loads(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    path.write_bytes(glb(DOCUMENT, DATA))
    scene = load_scene(path)
    assert (len(scene.nodes), len(scene.lights), len(scene.cameras)) == (4, 4, 1)
    assert scene.warnings == []


@RELAXED
@given(changes=st.lists(st.tuples(st.sampled_from(PLACES), VALUES, st.booleans()), min_size=1, max_size=3))
def test_mutated_json(tmp_path: Path, changes: list[tuple[tuple[Any, ...], Any, bool]]) -> None:
    document = copy.deepcopy(DOCUMENT)
    for place, value, remove in changes:
        holder: Any = document
        try:
            for key in place[:-1]:
                holder = holder[key]
            if remove:
                del holder[place[-1]]
            else:
                holder[place[-1]] = value
        except (KeyError, IndexError, TypeError):  # an earlier change removed this place
            continue
    load_bytes(tmp_path, glb(document, DATA))


@RELAXED
@given(changes=st.lists(st.tuples(st.integers(0), st.integers(0, 255)), min_size=1, max_size=8), cut=st.integers(0))
def test_mutated_bytes(tmp_path: Path, changes: list[tuple[int, int]], cut: int) -> None:
    data = bytearray(glb(DOCUMENT, DATA))
    for position, value in changes:
        data[position % len(data)] = value
    load_bytes(tmp_path, bytes(data) if cut % 4 else bytes(data[: cut // 4 % len(data)]))


@RELAXED
@given(changes=st.lists(st.tuples(st.integers(0), st.integers(0, 255)), min_size=1, max_size=6))
def test_mutated_buffers(tmp_path: Path, changes: list[tuple[int, int]]) -> None:
    data = bytearray(DATA)
    for position, value in changes:
        data[position % len(data)] = value
    load_bytes(tmp_path, glb(DOCUMENT, bytes(data)))


OBJ = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0 1 1 1\nvt 0 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\n"
PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)
STL = (
    b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    b"endloop\nendfacet\nendsolid s\n"
)


@RELAXED
@given(
    file=st.sampled_from([("scene.obj", OBJ), ("scene.ply", PLY), ("scene.stl", STL)]),
    changes=st.lists(st.tuples(st.integers(0), st.binary(max_size=6), st.integers(0, 6)), min_size=1, max_size=4),
)
def test_mutated_text_formats(tmp_path: Path, file: tuple[str, bytes], changes: list[tuple[int, bytes, int]]) -> None:
    name, data = file
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 1 0 0\nd 0.5\n")
    for position, replacement, removed in changes:
        start = position % (len(data) + 1)
        data = data[:start] + replacement + data[start + removed :]
    load_bytes(tmp_path, data, name)


# --- file access ------------------------------------------------------------------------------------------------------

OUTSIDE = ("../secret.bin", "../secret.png", "/etc/passwd")
VECTORS = [
    *OUTSIDE,
    "..",
    ".",
    "",
    "./../secret.bin",
    "sub/../../secret.bin",
    "sub/../../asset/../secret.bin",
    "sub/./../.././secret.bin",
    "//secret.bin",
    "///etc/passwd",
    "....//secret.bin",
    "..//secret.bin",
    "%2e%2e/secret.bin",
    "%2E%2E/secret.bin",
    ".%2e/secret.bin",
    "..%2fsecret.bin",
    "..%2Fsecret.bin",
    "%2e%2e%2fsecret.bin",
    "%252e%252e%252fsecret.bin",
    "%2fetc%2fpasswd",
    "..%5csecret.bin",
    "..\\secret.bin",
    "sub\\..\\..\\secret.bin",
    "\\etc\\passwd",
    "\\\\server\\share\\secret.bin",
    "C:\\secret.bin",
    "C:/secret.bin",
    "c:secret.bin",
    "%43%3a/secret.bin",
    "file:secret.bin",
    "file:///etc/passwd",
    "file://localhost/etc/passwd",
    "FILE:///etc/passwd",
    "fi%6ce:///etc/passwd",
    "http://127.0.0.1:9/secret.bin",
    "https://127.0.0.1:9/secret.bin",
    "ftp://127.0.0.1/secret.bin",
    "//127.0.0.1/secret.bin",
    "blob:secret.bin",
    "javascript:secret",
    "dаta:secret.bin",
    "..%00/secret.bin",
    "secret.bin%00.png",
    "../secret.bin%00",
    "link.bin",
    "link_folder/secret.bin",
    "link_chain.bin",
    "loop.bin",
    "pipe.bin",
    "sub",
    "~/secret.bin",
    "~root/.profile",
    "$HOME/secret.bin",
    "${HOME}/secret.bin",
    "%c0%ae%c0%ae/secret.bin",
    "..%c0%afsecret.bin",
    "\u2025/secret.bin",
    "..\u2215secret.bin",
    "..;/secret.bin",
    ".../secret.bin",
    "../asset_secret/secret.bin",
    "/dev/zero",
    "/proc/self/environ",
    "a" * 5000,
    "../" * 2000 + "etc/passwd",
]


MODULES = (".py", ".pyc")
"""Pillow imports its image formats when it meets the first image."""


class OpenedFiles:
    """Paths that Python code opens while `watch` is on. Audit hooks cannot be removed, so there is one, mostly idle."""

    def __init__(self) -> None:
        self.paths: list[str] = []
        self.watching = False
        sys.addaudithook(self._hear)

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.watching and event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)):
            self.paths.append(os.fsdecode(arguments[0]))
        if self.watching and event.startswith(("socket.", "urllib.", "subprocess.", "os.system")):
            self.paths.append(event)

    def during(self, action: Callable[[], None]) -> list[str]:
        self.paths, self.watching = [], True
        try:
            action()
        finally:
            self.watching = False
        return self.paths


OPENED = OpenedFiles()


@pytest.fixture(scope="module")
def asset_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with links that lead out of it, beside files that must stay unread."""
    parent = tmp_path_factory.mktemp("parent")
    folder = parent / "asset"
    (folder / "sub").mkdir(parents=True)
    (parent / "asset_secret").mkdir()
    for secret in (parent / "secret.bin", parent / "secret.png", parent / "asset_secret" / "secret.bin"):
        secret.write_bytes(DATA)
    try:
        (folder / "link.bin").symlink_to(parent / "secret.bin")
        (folder / "link_folder").symlink_to(parent)
        (folder / "link_chain.bin").symlink_to(folder / "link.bin")
        (folder / "loop.bin").symlink_to(folder / "loop.bin")
        os.mkfifo(folder / "pipe.bin")
    except (OSError, AttributeError):  # Windows without the right to make links: these vectors are missing files there
        pass
    return folder


def _as_buffer(vector: str) -> tuple[str, bytes]:
    return "scene.gltf", json.dumps({**DOCUMENT, "buffers": [{"uri": vector, "byteLength": len(DATA)}]}).encode()


def _as_image(vector: str) -> tuple[str, bytes]:
    uri = "data:;base64," + base64.b64encode(DATA).decode()
    document = {**DOCUMENT, "buffers": [{"uri": uri, "byteLength": len(DATA)}], "images": [{"uri": vector}]}
    return "scene.gltf", json.dumps(document).encode()


def _as_library(vector: str) -> tuple[str, bytes]:
    return "scene.obj", f"mtllib {vector}\n".encode() + OBJ.partition(b"\n")[2]


def _as_obj_texture(vector: str) -> tuple[str, bytes]:
    return "scene.obj", OBJ


@pytest.mark.parametrize("place", [_as_buffer, _as_image, _as_library, _as_obj_texture])
@pytest.mark.parametrize("number", range(len(VECTORS)))
def test_no_file_outside_the_folder_is_opened(asset_folder: Path, number: int, place: Any) -> None:
    vector = VECTORS[number]
    name, data = place(vector)
    scene_file = asset_folder / name
    scene_file.write_bytes(data)
    (asset_folder / "a.mtl").write_text(f"newmtl m\nmap_Kd {vector}\n", encoding="utf-8")
    outcome: list[SceneError | None] = []
    opened = OPENED.during(lambda: outcome.append(refusal(scene_file)))
    root = asset_folder.resolve()
    paths = [path for path in opened if not path.endswith(MODULES)]
    strangers = [path for path in paths if not Path(path).resolve().is_relative_to(root)]
    assert strangers == []
    (error,) = outcome
    if error is None:  # an empty name is no texture, and OBJ gives a lone backslash no meaning
        assert place in (_as_library, _as_obj_texture)
    else:
        assert error.code != "READER_FAILED"
    if vector in OUTSIDE:
        assert error is not None
        assert error.code == "URI_OUTSIDE_FOLDER"
