"""The trees of `bitmask`: one for each light where memory allows, else one that all share; fitted when it must be."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import softshadows as ss
from softshadows.techniques.bitmask.pictures import look

SIZE = (48, 36)
TREE_BYTES = 80
"""A triangle's."""


def lit_scene() -> ss.Scene:
    """`figures` under two rectangles, a disk and a line."""
    scene = ss.scenes.make("figures")
    (rect,) = scene.lights
    assert isinstance(rect, ss.RectLight)
    x, y, z = rect.position
    scene.lights = [
        rect,
        dataclasses.replace(rect, position=(-x, y, z)),
        ss.DiskLight((x, y, -z), rect.target, 0.4, (9.0, 9.0, 9.0)),
        ss.LineLight((x - 0.5, y, z), (x + 0.5, y, z), (9.0, 9.0, 9.0)),
    ]
    return scene


def renderer_of(scene: ss.Scene, memory_budget: int) -> ss.Renderer:
    return ss.Renderer(scene, size=SIZE, memory_budget=memory_budget)


def test_a_shared_tree_gives_the_same_bits_and_takes_less() -> None:
    scene = lit_scene()
    assert scene.camera is not None
    with renderer_of(scene, 512) as own, renderer_of(scene, 1) as shared:
        apart, together = own.render(scene.camera), shared.render(scene.camera)
        saved = apart.stats.gpu_bytes - together.stats.gpu_bytes
        assert saved == pytest.approx(3 * TREE_BYTES * scene.triangle_count, rel=0.01)
        assert np.array_equal(apart.visibility, together.visibility)
        for each in (own, shared):  # and again, with a light less, and another that moved
            scene.lights = [scene.lights[0], scene.lights[1].moved((0.1, 0.0, 0.0)), scene.lights[3]]
            found = each.render(scene.camera).visibility
            assert np.array_equal(found, ss.render(scene, size=SIZE).visibility)
            scene.lights = lit_scene().lights


def test_a_tree_is_fitted_when_its_light_or_the_scene_has_moved() -> None:
    scene = lit_scene()
    assert scene.camera is not None
    del scene.lights[1:]
    with renderer_of(scene, 512) as renderer:
        if "light_tree" not in renderer.render(scene.camera).stats.gpu_ms:
            pytest.skip("the adapter has no timestamps, by which this test sees what a frame did")
        assert "light_tree" not in renderer.render(scene.camera).stats.gpu_ms
        scene.lights = [scene.lights[0].moved((0.1, 0.0, 0.0))]
        assert "light_tree" in renderer.render(scene.camera).stats.gpu_ms
        scene.nodes[-1].transform = scene.nodes[-1].transform @ np.diag([0.9, 0.9, 0.9, 1.0])
        assert "light_tree" in renderer.render(scene.camera).stats.gpu_ms
        assert "light_tree" not in renderer.render(scene.camera).stats.gpu_ms


def test_a_shared_tree_is_fitted_before_it_is_looked_at() -> None:
    scene = lit_scene()
    assert scene.camera is not None
    with renderer_of(scene, 512) as own, renderer_of(scene, 1) as shared:
        for renderer in (own, shared):
            renderer.render(scene.camera)
        for index in (2, 0):
            one, other = (look(each.passes.technique, scene.lights[index], index) for each in (own, shared))
            assert np.array_equal(one.hidden, other.hidden)
            assert np.array_equal(one.boxes, other.boxes)
