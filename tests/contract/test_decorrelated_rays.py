"""Rays that ask about other points of the light in each pixel of a block, and the filter that averages blocks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.lights.grid import grid_samples
from softshadows.lights.jitter import block_strata, placed
from softshadows.lights.lattice import lattice_of
from softshadows.techniques import Rays

SIZE = (128, 96)
WIDE = (256, 192)
"""Where penumbrae are some pixels wide."""
GRID = 5


def block_points(light: Any) -> tuple[np.ndarray, np.ndarray]:
    """(16, n, 2): what the pixels of a block look at, and the samples' weights (n,)."""
    points = placed(lambda shift: grid_samples(light, GRID, "trapezoid", shift)[0], 0, "stratified")
    weights = grid_samples(light, GRID, "trapezoid")[1]
    return points.reshape(16, len(weights), 2), weights


def test_a_block_of_pixels_has_every_sixteenth_of_a_cell_once_along_either_side() -> None:
    shifts = np.sort(block_strata(), axis=0)
    middles = (np.arange(16) + 0.5) / 16.0 - 0.5
    assert np.array_equal(shifts, np.stack([middles, middles], axis=1))
    quarters = np.floor(4.0 * (block_strata() + 0.5)).reshape(4, 4, 2)
    assert (np.sort(quarters, axis=0) == np.arange(4.0)[:, None, None]).all()
    assert (np.sort(quarters, axis=1) == np.arange(4.0)[None, :, None]).all()


@pytest.mark.parametrize("kind", ["rect", "line"])
def test_a_block_covers_the_light_evenly(kind: str) -> None:
    """The share of the block's weight left of any place is that place's share of the light: the mean is unbiased."""
    light = stage.LIGHTS[kind]
    points, weights = block_points(light)
    for axis in range(2 if kind == "rect" else 1):
        half = light.half_extent[axis]
        for edge in np.linspace(-0.95, 0.95, 21):
            left = ((points[..., axis] < edge * half) * weights).sum(axis=1).mean() / weights.sum()
            assert left == pytest.approx((edge + 1.0) / 2.0, abs=1.0 / (16 * 2 * (GRID - 1)) + 1e-9)


@pytest.mark.parametrize("kind", ["rect", "line"])
def test_sheared_lattices_cover_the_light_evenly_too(kind: str) -> None:
    light = stage.LIGHTS[kind]
    lattice = lattice_of(light, 2)
    points = placed(lambda shift: lattice.points(light, shift, is_sheared=True), 0, "stratified").reshape(16, -1, 2)
    inner = [1.0 if i in (0, lattice.columns - 1) else 2.0 for i in range(lattice.columns)]
    weights = np.outer(inner, inner).ravel() if kind == "rect" else np.array(inner)
    for edge in np.linspace(-0.95, 0.95, 21):
        left = ((points[..., 0] < edge * light.half_extent[0]) * weights).sum(axis=1).mean() / weights.sum()
        assert left == pytest.approx((edge + 1.0) / 2.0, abs=1.0 / 64.0)


@pytest.mark.parametrize("kind", ["rect", "line", "disk"])
def test_every_pixel_sees_what_embree_sees_from_its_places_points(kind: str) -> None:
    light = stage.LIGHTS[kind]
    scene = stage.standard_scene(light)
    technique = ss.techniques.Uniform(grid=GRID, visibility=Rays("stratified"))
    frame = ss.render(scene, stage.CAMERA, technique=technique, size=stage.SIZE)
    points, weights = block_points(light)
    height, width = frame.surface.shape
    for place in range(16):
        world = light.center + points[place] @ light.axes[:2]
        seen = ss.truth.visibility_from_points(scene, frame, world, light=light)
        expected = np.tensordot(weights, seen, 1) / weights.sum()
        mask = np.zeros((height, width), bool)
        mask[place // 4 :: 4, place % 4 :: 4] = True
        assert np.abs(frame.visibility[0] - expected)[mask & frame.facing[0]].max() < 1e-6


TECHNIQUES = [
    ss.techniques.Adaptive(max_depth=2, visibility="ray"),
    ss.techniques.Uniform(grid=GRID, visibility="ray"),
]


def error_of(scene: ss.Scene, technique: Any, truth: np.ndarray, **options: Any) -> tuple[float, float]:
    """rmse and bias with other options."""
    frame = ss.render(scene, technique=replace(technique, visibility=Rays(**options)), size=WIDE)
    error = ss.metrics.compare(frame.visibility[0], truth, mask=frame.surface & frame.facing[0])
    return error.rmse, error.bias


@pytest.mark.parametrize("technique", TECHNIQUES, ids=lambda technique: technique.name)
def test_the_filter_takes_what_the_places_add_and_no_bias_is_left(technique: Any) -> None:
    scene = ss.scenes.blocker()
    truth = ss.truth.visibility(scene, ss.render(scene, technique="none", size=WIDE), samples=1024)[0]
    plain, _ = error_of(scene, technique, truth)
    placed_only, bias = error_of(scene, technique, truth, offsets="stratified")
    filtered, filtered_bias = error_of(scene, technique, truth, offsets="stratified", denoise=True)
    assert placed_only < 1.3 * plain
    assert filtered < 0.55 * plain
    assert abs(bias) < 1e-3
    assert abs(filtered_bias) < 1e-3


def test_the_filter_leaves_equal_values_and_hard_edges_exactly() -> None:
    """Hard shadows of a light without size, and a light that is all hidden or all seen."""
    scene = stage.standard_scene(stage.LIGHTS["point"])
    for grid in (1, 2):
        technique = ss.techniques.Uniform(grid=grid, visibility=Rays(denoise=True))
        frame = ss.render(scene, stage.CAMERA, technique=technique, size=SIZE)
        plain = ss.techniques.Uniform(grid=grid, visibility="ray")
        assert stage.same_bits(frame.visibility, ss.render(scene, stage.CAMERA, technique=plain, size=SIZE).visibility)


@pytest.mark.parametrize("technique", TECHNIQUES, ids=lambda technique: technique.name)
def test_only_windows_with_a_penumbra_change(technique: Any) -> None:
    scene = stage.standard_scene()
    plain, filtered = (
        ss.render(scene, stage.CAMERA, technique=replace(technique, visibility=Rays(denoise=on)), size=SIZE)
        for on in (False, True)
    )
    stage.check_visibility(filtered)
    assert filtered.stats.gpu_bytes == plain.stats.gpu_bytes + 4 * SIZE[0] * SIZE[1]
    is_penumbra = np.pad((plain.visibility[0] > 0.0) & (plain.visibility[0] < 1.0), 2)
    windows = np.lib.stride_tricks.sliding_window_view(is_penumbra, (5, 5)).any(axis=(2, 3))
    changed = plain.visibility[0] != filtered.visibility[0]
    assert changed.any()
    assert not (changed & ~windows).any()


def test_memory_is_the_same_in_every_frame() -> None:
    technique = ss.techniques.Uniform(grid=GRID, visibility=Rays("stratified", denoise=True))
    with ss.Renderer(stage.standard_scene(), technique=technique, size=stage.SIZE) as renderer:
        first, second = (renderer.render(stage.CAMERA).stats.gpu_bytes for _ in range(2))
    assert first == second


def test_places_and_the_filter_run_in_the_portable_profile() -> None:
    technique = ss.techniques.Adaptive(max_depth=2, visibility=Rays("stratified", denoise=True))
    scene = stage.standard_scene()
    full, portable = (
        ss.render(scene, stage.CAMERA, technique=technique, size=stage.SIZE, profile=profile)
        for profile in ("full", "portable")
    )
    assert np.abs(full.visibility - portable.visibility).max() < 1e-3


@pytest.mark.parametrize("visibility", ["map", "hybrid"])
@pytest.mark.parametrize("option", ["offsets", "denoise"])
@pytest.mark.parametrize("name", ["adaptive", "uniform"])
def test_maps_have_neither(name: str, option: str, visibility: str) -> None:
    with pytest.raises(ss.OptionError, match=f"visibility={visibility} has no option '{option}'; visibility=ray has"):
        ss.techniques.make_technique(name, {"visibility": visibility, f"visibility.{option}": "none"})
