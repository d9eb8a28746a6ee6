"""The scaling suite: what grows, what stays, and a small step that leaves its figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from softshadows.bench.suites import Settings, find_suite, scaling
from softshadows.compare.results import results
from softshadows.techniques import make_technique


def test_every_axis_grows() -> None:
    chosen = list(scaling.steps(scaling.SIZE))
    assert find_suite("scaling") is scaling.run
    for axis in ("pixels", "triangles", "lights", "hills", "light size"):
        amounts = [step.amount for step in chosen if step.axis == axis]
        assert amounts == sorted(set(amounts))
        assert amounts[-1] >= 4 * amounts[0]
    assert len({step.name for step in chosen}) == len(chosen)
    assert all(step.size == scaling.SIZE for step in chosen if step.axis != "pixels")


@pytest.mark.parametrize("count", [1, 3])
def test_several_lights_share_the_power_of_one(count: int) -> None:
    (one,) = scaling.lit_by(1).lights
    lights = scaling.lit_by(count).lights
    assert len(lights) == count
    np.testing.assert_allclose(np.sum([light.emission for light in lights], axis=0), one.emission)
    np.testing.assert_allclose(np.mean([light.center for light in lights], axis=0), one.center)


def test_a_wider_light_has_the_same_power() -> None:
    (one,), (wide,) = (scaling.lit_widely(factor).lights for factor in (1.0, 4.0))
    assert wide.half_extent == tuple(4.0 * extent for extent in one.half_extent)
    np.testing.assert_allclose(16.0 * np.array(wide.emission), one.emission)


def test_small_steps() -> None:
    settings = Settings(samples=16, repeats=2)
    lit = next(step for step in scaling.steps((32, 24)) if step.name == "lights 2")
    lit = replace(lit, techniques=[make_technique("hard"), make_technique("none")])
    sampled = next(step for step in scaling.steps((32, 24)) if step.axis == "light samples")
    sampled = replace(sampled, techniques=[make_technique("uniform", {"grid": grid}) for grid in (2, 3)])
    found = [scaling.measure_step(step, settings, lambda doing, share: None) for step in (lit, sampled)]
    assert [m.figures for m in found] == [{"axis": "lights"}, {"axis": "light samples"}]
    hard, none = found[0].results
    assert hard.figures == {"series": "hard", "amount": 2}
    assert len(hard.comparisons) == 2
    assert hard.stats["shadow_maps"] == 2
    assert hard.times["frame"].frames == 2
    assert none.comparisons[0].rmse > hard.comparisons[0].rmse
    assert [result.figures for result in found[1].results] == [
        {"series": "uniform", "amount": 4},
        {"series": "uniform", "amount": 9},
    ]
    data = results(found, suite="scaling")
    times = data["pictures"][0]["techniques"][0]["times"]["frame"]
    assert times["fastest_ms"] <= times["median_ms"] <= times["slowest_ms"]
