"""Refined frames step toward the truth, and stay what one frame shows where a technique has no samples to move."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.lights.grid import grid_samples
from softshadows.lights.jitter import jitter_shift, moved
from softshadows.lights.lattice import lattice_of
from softshadows.techniques import Adaptive, Hard, Technique, Uniform

SIZE = (96, 72)
FRAMES = 16


def test_moved_trapezoid_samples_cover_the_light_evenly() -> None:
    """Averaged over all shifts, the share of the weight left of any place is that place's share of the light."""
    steps, weights = np.linspace(-1.0, 1.0, 5), np.array([1.0, 2.0, 2.0, 2.0, 1.0]) / 8.0
    shifts = (np.arange(1000) + 0.5) / 1000.0 - 0.5
    places = np.stack([moved(steps, 0.5, shift) for shift in shifts])
    for edge in np.linspace(-0.95, 0.95, 21):
        left = ((places < edge) * weights).sum(axis=1).mean()
        assert left == pytest.approx((edge + 1.0) / 2.0, abs=2e-3)


def test_the_first_place_is_the_lattice_and_others_differ() -> None:
    assert jitter_shift(0) == (0.0, 0.0)
    shifts = np.array([jitter_shift(number) for number in range(64)])
    assert np.abs(shifts).max() <= 0.5
    assert len(np.unique(np.floor(8.0 * (shifts + 0.5)), axis=0)) >= 40  # of 64 squares
    lattice = lattice_of(stage.RECT, 2)
    assert np.array_equal(lattice.points(stage.RECT), lattice.points(stage.RECT, jitter_shift(0)))
    for shift in map(jitter_shift, (1, 2, 100)):
        points = lattice.points(stage.RECT, shift)
        assert (np.abs(points) <= np.array(stage.RECT.half_extent) + 1e-12).all()
        assert np.allclose(points, grid_samples(stage.RECT, 5, "trapezoid", shift)[0])


@pytest.mark.parametrize("technique", [Uniform(grid=3), Adaptive(max_depth=2)], ids=["uniform", "adaptive"])
def test_the_mean_steps_toward_the_truth(technique: Technique) -> None:
    scene = ss.scenes.blocker()
    assert scene.camera is not None
    with ss.Renderer(scene, technique=technique, size=SIZE) as renderer:
        first = renderer.render(scene.camera)
        frames = [renderer.refine(scene.camera) for _ in range(FRAMES)]
        again = renderer.render(scene.camera)
    assert np.array_equal(frames[0].visibility, first.visibility)
    assert np.array_equal(again.visibility, first.visibility)
    truth = ss.truth.visibility(scene, first, samples=1024)
    mask = first.surface & first.facing[0]
    errors = [ss.metrics.compare(frame.visibility[0], truth[0], mask=mask).rmse for frame in (frames[0], frames[-1])]
    assert errors[1] <= errors[0] / 3.0
    shadowed = first.visibility[0] > 0.0
    assert np.allclose(
        frames[-1].color[shadowed] / np.maximum(frames[-1].visibility[0], 1e-6)[shadowed, None],
        first.color[shadowed] / np.maximum(first.visibility[0], 1e-6)[shadowed, None],
        rtol=1e-3,
    )


def test_a_change_starts_afresh() -> None:
    scene = ss.scenes.blocker()
    assert scene.camera is not None
    camera = dataclasses.replace(scene.camera, vertical_fov=30.0)
    with ss.Renderer(scene, technique=Uniform(grid=2), size=SIZE) as renderer:
        for _ in range(3):
            renderer.refine(scene.camera)
        assert np.array_equal(renderer.refine(camera).visibility, renderer.render(camera).visibility)
        scene.lights = [dataclasses.replace(scene.lights[0], radiance=(1.0, 1.0, 1.0))]
        assert np.array_equal(renderer.refine(camera).color, renderer.render(camera).color)


def test_a_technique_without_samples_stays() -> None:
    scene = ss.scenes.blocker()
    assert scene.camera is not None
    with ss.Renderer(scene, technique=Hard(), size=SIZE) as renderer:
        first = renderer.refine(scene.camera)
        assert np.array_equal(renderer.refine(scene.camera).visibility, first.visibility)
