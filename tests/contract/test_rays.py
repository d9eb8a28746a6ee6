"""Rays on the GPU see what Embree sees from the same points of the light, in every technique that can ask them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.lights.grid import grid_samples

GRID = 5
SIZE = (96, 72)
SCENES = ("sphere_cube", "leaves", "figures", "fence")
"""leaves has alpha masks, fence thin bars, figures many triangles."""


def share_seen_by_embree(scene: ss.Scene, frame: ss.Frame, light: Any) -> np.ndarray:
    """(height, width): the weighted share of uniform sampling's points that each pixel sees."""
    points, weights = grid_samples(light, GRID, "trapezoid")
    world = light.center + points @ light.axes[:2]
    seen = ss.truth.visibility_from_points(scene, frame, world, light=light)
    return np.tensordot(weights, seen, 1) / weights.sum()


@pytest.mark.parametrize("name", SCENES)
def test_uniform_rays_are_embrees(name: str) -> None:
    """No pixel differs: a bound of 1e-5 of the rays (the issue's) would allow one ray in a hundred thousand."""
    scene = getattr(ss.scenes, name)()
    frame = ss.render(scene, technique=ss.techniques.Uniform(grid=GRID, visibility="ray"), size=SIZE)
    differs = frame.visibility[0] != share_seen_by_embree(scene, frame, frame.lights[0]).astype(np.float32)
    assert (frame.surface & frame.facing[0]).sum() > 1000
    assert not (differs & frame.surface & frame.facing[0]).any()


@pytest.mark.parametrize("kind", [kind for kind in stage.LIGHTS if kind != "directional"])
def test_every_kind_of_light_casts_rays(kind: str) -> None:
    scene = stage.standard_scene(stage.LIGHTS[kind])
    frame = ss.render(scene, stage.CAMERA, technique=ss.techniques.Uniform(grid=GRID, visibility="ray"), size=SIZE)
    differs = np.abs(frame.visibility[0] - share_seen_by_embree(scene, frame, frame.lights[0])) > 1e-6
    assert not (differs & frame.facing[0]).any()


def test_a_directional_lights_rays_leave_the_scene() -> None:
    scene = stage.standard_scene(stage.LIGHTS["directional"])
    frame = ss.render(scene, stage.CAMERA, technique=ss.techniques.Uniform(grid=1, visibility="ray"), size=SIZE)
    truth = ss.truth.visibility(scene, frame, samples=1)
    assert (frame.visibility[0] == truth[0])[frame.facing[0]].all()


@pytest.mark.parametrize("visibility", ["ray", "hybrid"])
@pytest.mark.parametrize("name", ["sphere_cube", "leaves"])
def test_adaptive_rays_are_near_uniform_ones(name: str, visibility: str) -> None:
    scene = getattr(ss.scenes, name)()
    uniform = ss.render(scene, technique=ss.techniques.Uniform(grid=17, visibility="ray"), size=SIZE)
    technique = ss.techniques.Adaptive(visibility=visibility)
    frame = ss.render(scene, technique=technique, size=SIZE)
    error = ss.metrics.compare(frame.visibility[0], uniform.visibility[0], mask=frame.surface & frame.facing[0])
    assert error.rmse < 0.02
    assert error.leak_rate == 0.0
    assert error.false_shadow_rate == 0.0


def test_hybrid_is_exact_where_maps_are_certain_and_close_elsewhere() -> None:
    scene = ss.scenes.sphere_cube()
    rays, maps, hybrid = (
        ss.render(scene, technique=ss.techniques.Uniform(grid=GRID, visibility=v, resolution=texels), size=SIZE)
        for v, texels in (("ray", "auto"), ("map", 256), ("hybrid", 256))
    )
    mask = rays.surface & rays.facing[0]

    def rmse(frame: ss.Frame) -> float:
        return ss.metrics.compare(frame.visibility[0], rays.visibility[0], mask=mask).rmse

    assert rmse(hybrid) < 0.25 * rmse(maps)


def test_moved_nodes_cast_their_shadow_where_they_are() -> None:
    scene = stage.standard_scene()
    technique = ss.techniques.Uniform(grid=GRID, visibility="ray")
    with ss.Renderer(scene, technique=technique, size=SIZE) as renderer:
        renderer.render(stage.CAMERA)
        for step in (0.2, -0.3):
            moved = scene.nodes[-1]
            moved.transform = moved.transform @ _shift(step)
            frame = renderer.render(stage.CAMERA)
            fresh = ss.render(scene, stage.CAMERA, technique=technique, size=SIZE)
            assert (frame.visibility == fresh.visibility).all()


def _shift(metres: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[0, 3] = metres
    return matrix


def test_a_scene_without_triangles_is_lit() -> None:
    scene = ss.Scene([], [stage.RECT])
    frame = ss.render(scene, stage.CAMERA, technique=ss.techniques.Adaptive(visibility="ray"), size=(16, 12))
    assert (frame.visibility == 1.0).all()


@pytest.mark.parametrize("visibility", ["ray", "hybrid"])
@pytest.mark.parametrize("name", ["uniform", "adaptive"])
def test_rays_run_in_the_portable_profile(name: str, visibility: str) -> None:
    technique = stage.cheap(name, visibility=visibility)
    scene = stage.standard_scene()
    full = ss.render(scene, stage.CAMERA, technique=technique, size=stage.SIZE)
    frame = ss.render(scene, stage.CAMERA, technique=technique, size=stage.SIZE, profile="portable")
    assert np.abs(full.visibility - frame.visibility).max() < 1e-3


def test_alpha_masks_run_in_the_portable_profile() -> None:
    technique = ss.techniques.Uniform(grid=GRID, visibility="ray")
    full = ss.render(ss.scenes.leaves(), technique=technique, size=SIZE)
    frame = ss.render(ss.scenes.leaves(), technique=technique, size=SIZE, profile="portable")
    assert np.abs(full.visibility - frame.visibility).max() < 1e-3
    assert np.ptp(full.visibility) == 1.0


@pytest.mark.parametrize("options", [{"filter": "pcf"}, {"filter": "cell"}, {"resolution": 256}])
def test_filters_need_maps(options: dict) -> None:
    with pytest.raises(ss.OptionError, match="shadow maps"):
        ss.techniques.Adaptive(visibility="ray", **options)
