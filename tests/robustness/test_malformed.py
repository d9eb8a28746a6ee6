"""Every file of a corpus of broken scenes is answered by SceneError or a load, quickly and without much memory.

The corpus was collected from the test suites of the Khronos glTF validator, assimp, magnum, tinygltf and others. Below
it stand bombs: small files, made here, that declare enormous contents.
"""

from __future__ import annotations

import base64
import json
import os
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from softshadows.errors import SceneError
from softshadows.scene.geometry import flatten
from softshadows.scene.load import LOADERS, load_scene
from softshadows.scene.model import Scene

FOLDER = os.environ.get("SOFTSHADOWS_SCENES")
MAX_SECONDS = 2.0
MAX_MEBIBYTES = 512


def manifest() -> list[dict[str, Any]]:
    path = Path(FOLDER or ".") / "malformed" / "manifest.json"
    return json.loads(path.read_text()) if FOLDER and path.exists() else []


def scene_or_error(path: Path) -> Scene | SceneError:
    try:
        return load_scene(path)
    except SceneError as error:
        return error


def answer(path: Path) -> str:
    """ "loaded", or the code of the SceneError. Whatever loads must be finite and consistent."""
    start = time.process_time()
    scene = scene_or_error(path)
    assert time.process_time() - start <= MAX_SECONDS
    if isinstance(scene, SceneError):
        assert scene.code not in (None, "READER_FAILED"), scene
        assert scene.file == str(path)
        return str(scene.code)
    if scene.triangle_count > 100_000:
        return "loaded"
    geometry = flatten(scene)
    assert np.isfinite(geometry.positions).all()
    assert geometry.triangles.size == 0 or geometry.triangles.max() < len(geometry.positions)
    return "loaded"


@pytest.mark.scenes
@pytest.mark.skipif(not FOLDER, reason="SOFTSHADOWS_SCENES does not name a folder of real scenes")
@pytest.mark.parametrize("entry", manifest(), ids=lambda entry: entry["file"])
def test_malformed_file(entry: dict[str, Any]) -> None:
    path = Path(FOLDER or ".") / "malformed" / entry["file"]
    result = answer(path)
    if path.suffix not in LOADERS:
        assert result == "FORMAT_UNSUPPORTED"
    if entry["bytes"] == 0:
        assert result != "loaded"


MEMORY_OF_LOADS = """
import json, re, sys
from pathlib import Path
import numpy, PIL.Image, trimesh, trimesh.exchange.ply
from softshadows.errors import SceneError
from softshadows.scene.load import load_scene

def peak():  # kibibytes; unlike ru_maxrss it does not start at the parent's peak
    return int(re.search(r"VmHWM:\\s+([0-9]+)", Path("/proc/self/status").read_text())[1])

base = peak()
for path in json.load(sys.stdin):
    try:
        load_scene(path)
    except SceneError:
        pass
print((peak() - base) / 1024)
"""


def peak_mebibytes(paths: list[Path]) -> float:
    """How far loading `paths`, one after another in a new process, raises its peak resident memory."""
    run = subprocess.run(
        [sys.executable, "-c", MEMORY_OF_LOADS],
        input=json.dumps([str(path) for path in paths]),
        capture_output=True,
        text=True,
        check=True,
    )
    return float(run.stdout)


@pytest.mark.scenes
@pytest.mark.skipif(not FOLDER, reason="SOFTSHADOWS_SCENES does not name a folder of real scenes")
@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is read from /proc")
def test_the_corpus_needs_little_memory() -> None:
    paths = [Path(FOLDER or ".") / "malformed" / entry["file"] for entry in manifest()]
    assert peak_mebibytes(paths) <= MAX_MEBIBYTES


# --- bombs ------------------------------------------------------------------------------------------------------------


def gltf(**root: Any) -> bytes:
    return json.dumps({"asset": {"version": "2.0"}, **root}).encode()


def placed(accessor: dict[str, Any], **root: Any) -> bytes:
    """A triangle mesh whose positions are `accessor`."""
    return gltf(
        accessors=[accessor], meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}], nodes=[{"mesh": 0}], **root
    )


def zeros(count: int, **properties: Any) -> dict[str, Any]:
    return {"componentType": 5126, "type": "VEC3", "count": count, **properties}


def png_declaring(width: int, height: int) -> str:
    """A data URI of a PNG file that declares these sizes and holds a few bytes."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    data = (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    )
    return "data:image/png;base64," + base64.b64encode(data).decode()


def textured(uri: str) -> bytes:
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    return gltf(images=[{"uri": uri}], textures=[{"source": 0}], materials=[material])


def ply(count: int, encoding: str = "binary_little_endian") -> bytes:
    header = (
        f"ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"
    )
    return (header + f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n").encode() + bytes(64)


BUFFER = {"uri": "data:application/octet-stream;base64," + "A" * 4000, "byteLength": 3000}
SPARSE = {"indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}
BOMBS: dict[str, tuple[str, bytes]] = {
    "accessor count": (".gltf", placed(zeros(2**40))),
    "accessor count beyond 64 bits": (".gltf", placed(zeros(10**30))),
    "accessor count at the limit of the budget": (".gltf", placed(zeros(8_000_000))),
    "many accessors of zeros": (
        ".gltf",
        gltf(
            accessors=[zeros(5_000_000) for _ in range(200)],
            meshes=[{"primitives": [{"attributes": {"POSITION": i}} for i in range(200)]}],
            nodes=[{"mesh": 0}],
        ),
    ),
    "many primitives of one accessor": (
        ".gltf",
        gltf(
            accessors=[zeros(2_500_000)],
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 20_000}],
            nodes=[{"mesh": 0}],
        ),
    ),
    "sparse count": (
        ".gltf",
        placed(
            zeros(2**40, sparse={"count": 2**40, **SPARSE}),
            buffers=[BUFFER],
            bufferViews=[{"buffer": 0, "byteLength": 3000}],
        ),
    ),
    "buffer length": (".gltf", gltf(buffers=[{**BUFFER, "byteLength": 2**52}])),
    "meshopt count": (
        ".gltf",
        placed(
            zeros(2**28, bufferView=0),
            buffers=[BUFFER, {"byteLength": 2**40}],
            bufferViews=[
                {
                    "buffer": 1,
                    "byteLength": 2**32,
                    "byteStride": 16,
                    "extensions": {
                        "EXT_meshopt_compression": {
                            "buffer": 0,
                            "byteLength": 3000,
                            "byteStride": 16,
                            "count": 2**28,
                            "mode": "ATTRIBUTES",
                        }
                    },
                }
            ],
        ),
    ),
    "image of 65535 pixels a side": (".gltf", textured(png_declaring(65535, 65535))),
    "image of 16384 pixels a side": (".gltf", textured(png_declaring(16384, 16384))),
    "image out of proportion": (".gltf", textured(png_declaring(8192, 8192))),
    "truncated image": (".gltf", textured(png_declaring(2048, 2048))),
    "nested arrays": (".gltf", b'{"asset": {"version": "2.0"}, "extras": ' + b"[" * 500_000 + b"]" * 500_000 + b"}"),
    "huge integer": (".gltf", b'{"asset": {"version": "2.0"}, "scene": ' + b"9" * 3_000_000 + b"}"),
    "instanced triangles": (
        ".gltf",
        gltf(
            accessors=[zeros(3_000_000)],
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
            nodes=[{"mesh": 0} for _ in range(1000)],
        ),
    ),
    "binary ply": (".ply", ply(2_000_000_000)),
    "ply element without properties": (
        ".ply",
        ply(1).replace(b"element face", b"element nothing 999999999999\nelement face"),
    ),
    "ply list length": (".ply", ply(1).replace(b"list uchar", b"list uint") + b"\xff" * 64),
    "ascii ply": (".ply", ply(2_000_000_000, "ascii")),
    "binary stl": (".stl", bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50)),
    "obj index": (".obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999999999999999\n"),
    "obj index within 31 bits": (".obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2147483646\n"),
}


def bomb_file(folder: Path, name: str) -> Path:
    suffix, data = BOMBS[name]
    path = folder / f"{name.replace(' ', '_')}{suffix}"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", BOMBS)
def test_bombs_are_refused_or_harmless(tmp_path: Path, name: str) -> None:
    result = answer(bomb_file(tmp_path, name))
    assert (result == "loaded") == (name == "accessor count at the limit of the budget")


@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is read from /proc")
def test_bombs_need_little_memory(tmp_path: Path) -> None:
    assert peak_mebibytes([bomb_file(tmp_path, name) for name in BOMBS]) <= MAX_MEBIBYTES
