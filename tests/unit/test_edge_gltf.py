"""Valid glTF edge cases of the Khronos asset generator, and real scenes: all load and agree with what is known."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from softshadows.errors import SceneError
from softshadows.scene.geometry import flatten
from softshadows.scene.load import load_scene

FOLDER = os.environ.get("SOFTSHADOWS_SCENES")
pytestmark = [
    pytest.mark.scenes,
    pytest.mark.skipif(not FOLDER, reason="SOFTSHADOWS_SCENES does not name a folder of real scenes"),
]
ROOT = Path(FOLDER or ".")

NEEDS_GLTF_2_1 = "Compatibility/Compatibility_04.glb"
"""Its minVersion is 2.1; the asset generator lists it as one that a glTF 2.0 reader must refuse."""


def manifest() -> list[dict[str, Any]]:
    path = ROOT / "edge_gltf" / "manifest.json"
    return json.loads(path.read_text()) if FOLDER and path.exists() else []


@pytest.mark.parametrize("entry", manifest(), ids=lambda entry: Path(entry["file"]).stem)
def test_every_edge_case_loads_with_its_triangles(entry: dict[str, Any]) -> None:
    path = ROOT / "edge_gltf" / entry["file"]
    if entry["file"] == NEEDS_GLTF_2_1:
        with pytest.raises(SceneError, match="UNKNOWN_ASSET_MINOR_VERSION"):
            load_scene(path)
        return
    scene = load_scene(path)
    assert scene.triangle_count == entry["gltf"].get("inst", 0), scene.warnings
    geometry = flatten(scene)
    assert np.isfinite(geometry.positions).all()


@pytest.mark.parametrize("group", ["Buffer_Interleaved", "Instancing", "Node_Attribute", "Node_NegativeScale"])
def test_bounds_agree_with_trimesh(group: str) -> None:
    trimesh = pytest.importorskip("trimesh")
    for path in sorted((ROOT / "edge_gltf" / group).glob("*.glb")):
        geometry = flatten(load_scene(path))
        ours = geometry.positions[geometry.triangles].reshape(-1, 3)
        theirs = trimesh.load_scene(path, process=False).to_geometry().triangles.reshape(-1, 3)
        for bound in (np.min, np.max):
            np.testing.assert_allclose(bound(ours, axis=0), bound(theirs, axis=0), atol=1e-5, err_msg=path.name)


SCENES = {
    "alpha_blend_mode_test/alpha_blend_mode_test.glb": 61,
    "cesium_man/cesium_man.glb": 4672,
    "cornell_box_nv/cornell_box.obj": 36,
    "dutch_ship/dutch_ship.glb": 69162,
    "japanese_classroom/japanese_classroom.glb": 103832,
    "monobloc_chair/monobloc_chair.glb": 3356,
    "scorpion/scorpion.glb": 99990,
}
"""Triangles of the quick ones among the real scenes."""


@pytest.mark.parametrize("name", SCENES)
def test_real_scenes_load(name: str) -> None:
    assert load_scene(ROOT / name).triangle_count == SCENES[name]


def test_a_big_scene_loads_in_seconds() -> None:
    start = time.process_time()
    scene = load_scene(ROOT / "sponza_crytek" / "sponza_crytek.glb")
    seconds = time.process_time() - start
    assert scene.triangle_count == 262267
    materials = {id(node.mesh.material): node.mesh.material for node in scene.nodes}.values()
    assert sum(material.base_color_texture is not None for material in materials) == 25
    assert sum(material.alpha_cutoff is not None for material in materials) == 3
    assert seconds < 30.0, "47 MB with textures take 5 s on two shared cores"


def test_relative_obj_indices_count_from_their_line() -> None:
    scene = load_scene(ROOT / "cornell_box_nv" / "cornell_box.obj")
    light = next(node.mesh for node in scene.nodes if node.mesh.material.name == "light")
    assert light.positions[:, 1].tolist() == [548.0] * 4
