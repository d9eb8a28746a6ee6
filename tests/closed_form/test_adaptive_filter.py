"""Adaptive light sampling's filters: the extra look-ups of PCF and of `filter="cell"`.

The scene is the built-in blocker, a card over a floor under a parallel light: its umbra, penumbra and lit region are a
closed form (O4).
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
import stage
from softshadows import metrics
from softshadows.techniques import Adaptive, PcfFilter
from softshadows.truth import closed_form, visibility

H, h, HALF, CARD = 10.0, 4.0, 1.0, (-1.5, 1.5, -1.0, 1.0)  # of the built-in scene
SIZE = (96, 72)
BLOCKER = ss.scenes.blocker()

both_refinements = pytest.mark.parametrize("refinement", ["global", "tile"])


def frame_of(size: tuple[int, int] = SIZE, **options: Any) -> ss.Frame:
    budget = {"memory_budget": options.pop("memory_budget")} if "memory_budget" in options else {}
    return ss.render(BLOCKER, technique=Adaptive(**{"resolution": 512, **options}), size=size, **budget)


def exact(frame: ss.Frame) -> npt.NDArray[np.float64]:
    """(height, width): the share of the light that each pixel of the floor sees."""
    x, z = (frame.position[..., axis].astype(np.float64) for axis in (0, 2))
    return closed_form.rectangle(x, z, H, h, HALF, HALF, CARD)


def away_from_edges(frame: ss.Frame, value: float, pixels: int = 2) -> npt.NDArray[np.bool_]:
    """Floor whose neighbours within `pixels` are floor and have this visibility, too."""
    same = (exact(frame) == value) & (np.abs(frame.position[..., 1]) < 1e-3) & frame.surface
    padded = np.pad(same, pixels)
    height, width = same.shape
    steps = range(2 * pixels + 1)
    return np.all([padded[dy : dy + height, dx : dx + width] for dy in steps for dx in steps], axis=0)


@pytest.mark.parametrize("options", [{"filter": PcfFilter(2)}, {"filter": PcfFilter(3)}, {"filter": "cell"}], ids=str)
@pytest.mark.parametrize("weights", ["area", "paper"])
@both_refinements
def test_filters_leave_umbra_and_full_light_exact(options: dict[str, Any], weights: str, refinement: str) -> None:
    """Finite and in [0, 1] everywhere; 0 and 1 to the bit away from the penumbra. The trees are the unfiltered ones."""
    frame = frame_of(**options, weights=weights, refinement=refinement, max_depth=3)
    stage.check_visibility(frame)
    for value in (0.0, 1.0):
        apart = away_from_edges(frame, value)
        assert np.count_nonzero(apart) > 50
        assert (frame.visibility[0][apart] == value).all()
    plain = frame_of(weights=weights, refinement=refinement, max_depth=3)
    assert not stage.same_bits(frame.visibility, plain.visibility), "the filter does something"
    assert frame.stats.shadow_maps == plain.stats.shadow_maps
    assert frame.stats.lookups_per_pixel == plain.stats.lookups_per_pixel
    assert frame.stats.warnings == plain.stats.warnings


@pytest.mark.parametrize("kind", ["rect", "line"])
@pytest.mark.parametrize("options", [{"filter": PcfFilter(2)}, {"filter": PcfFilter(3)}, {"filter": "cell"}], ids=str)
def test_filters_stay_in_range_among_boxes_and_contacts(options: dict[str, Any], kind: str) -> None:
    """No tile is whole at this size, and the scene has contacts and faces that the light grazes."""
    made = stage.standard_scene(stage.LIGHTS[kind])
    for max_depth in (0, 2, 4):
        frame = stage.render(made, Adaptive(resolution=256, max_depth=max_depth, **options), size=(61, 45))
        stage.check_visibility(frame)
        penumbra = (frame.visibility > 0.0) & (frame.visibility < 1.0)
        assert penumbra.any()


@functools.cache
def truth_of(size: tuple[int, int]) -> npt.NDArray[np.float32]:
    return visibility(BLOCKER, frame_of(size, max_depth=0), samples=1024)[0]


@both_refinements
def test_cells_halve_the_error_of_25_maps(refinement: str) -> None:
    """Rays say so, and the closed form says that the rays are right."""
    plain, filtered = (frame_of(refinement=refinement, max_depth=2, filter=rule) for rule in ("none", "cell"))
    assert plain.stats.shadow_maps == filtered.stats.shadow_maps == 25
    truth, mask = truth_of(SIZE), plain.surface & plain.facing[0]
    floor = mask & (np.abs(plain.position[..., 1]) < 1e-3)
    assert np.abs(truth - exact(plain))[floor].max() < 0.02  # 32 × 32 jittered points
    found = metrics.compare(filtered.visibility[0], truth, mask)
    unfiltered = metrics.compare(plain.visibility[0], truth, mask)
    assert found.penumbra_pixels > 200
    assert found.penumbra_rmse <= 0.5 * unfiltered.penumbra_rmse, (found, unfiltered)


@pytest.mark.parametrize("options", [{"filter": "pcf"}, {"filter": "cell"}], ids=str)
def test_maps_beyond_the_memory_budget_are_refused(options: dict[str, Any]) -> None:
    """A filter needs all 289 maps at one time: 17² × 512² × 4 bytes are 289 MiB. Without one, batches do."""
    with pytest.raises(ss.DeviceError, match="memory_budget"):
        frame_of((16, 16), memory_budget=288, **options)
    frame_of((16, 16), memory_budget=288)
    stage.check_visibility(frame_of((16, 16), memory_budget=1, resolution="auto", **options))  # smaller maps instead


def test_no_filter_is_the_default() -> None:
    plain, named = frame_of(), frame_of(filter="none")
    assert stage.same_bits(plain.visibility, named.visibility)
    assert plain.stats.lookups_per_pixel == named.stats.lookups_per_pixel
