"""The linear suite: its views, and a small run that leaves all figures and pictures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from softshadows.bench.suites import Settings, baselines, find_suite, linear
from softshadows.bench.suites.linear import View, measure_view, views
from softshadows.compare.results import results
from softshadows.errors import SceneError
from softshadows.scene.lights import LineLight
from softshadows.techniques import OccludingEdges, Uniform

SIZE = (48, 36)


def test_every_view_has_a_line_light_and_two_point_lights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(baselines.SCENES_VARIABLE, raising=False)
    found = list(views())
    assert [view.name for view in found[:6]] == [*linear.BUILTIN, "triangle", "resolution"]
    assert len(found) == 6 + len(linear.SPHERES)
    for view in found[:-1]:  # the last one has a million triangles
        lines = 3 if view.triangle else 1
        assert [light.kind for light in view.open().scene.lights] == lines * ["line"]
        assert view.techniques[0].name == "uniform"
        assert view.techniques[0].grid == 2  # type: ignore[attr-defined]
    monkeypatch.setenv(baselines.SCENES_VARIABLE, str(tmp_path))
    with pytest.raises(SceneError, match="SOFTSHADOWS_SCENES"):
        list(views())


def test_the_line_is_as_long_as_the_light_was_wide_and_as_bright() -> None:
    light = next(views()).open().scene.lights[0]
    assert isinstance(light, LineLight)
    assert light.half_extent[0] == pytest.approx(0.45)


def test_a_small_run(tmp_path: Path) -> None:
    plain = [Uniform(grid=count) for count in (2, 5, 17)]
    fixed = [Uniform(grid=2, resolution=128), OccludingEdges(samples=2, resolution=128)]
    view = View("small", next(views()).open, [*plain, *fixed])
    measurement = measure_view(view, Settings(SIZE, 256, 1, tmp_path), lambda doing, share: None)
    assert not measurement.skipped
    hard, five, many, hard_fixed, edges = (result.figures for result in measurement.results)
    assert hard["time_over_hard"] == hard_fixed["time_over_hard"] == 1.0
    assert hard["rmse_truth"] > five["rmse_truth"] > many["rmse_truth"]
    assert (hard["equal_uniform"], five["equal_uniform"], many["equal_uniform"]) == (2.0, pytest.approx(5.0), 17.0)
    assert hard["outreach_share"] is hard["cached_over_hard"] is None
    assert hard_fixed["cached_over_hard"] == 1.0
    assert edges["cached_over_hard"] > 0.0
    assert 0.0 < edges["outreach_share"] < 1.0
    assert edges["rmse_truth"] < hard_fixed["rmse_truth"]
    assert [entry["samples"] for entry in measurement.figures["rays"]] == list(linear.RAYS)
    data = json.loads(json.dumps(results([measurement], suite="linear"), allow_nan=False))
    assert data["pictures"][0]["techniques"][4]["figures"] == edges
    assert (tmp_path / "small" / "truth.png").exists()
    assert (tmp_path / "small" / "occluding-edges-samples-2-resolution-128.png").exists()


def test_a_triangle_is_shadowed_by_its_sides() -> None:
    view = replace(next(view for view in views() if view.triangle), techniques=[Uniform(grid=2), Uniform(grid=9)])
    measurement = measure_view(view, Settings(SIZE, 256, 1), lambda doing, share: None)
    two, nine = (result.figures["rmse_area"] for result in measurement.results)
    outline = measurement.figures["outline_rmse"]
    assert 0.0 < outline < 0.05, "the sides see nearly what the triangle sees"
    assert nine < two
    assert abs(nine - outline) < 0.02


def test_the_suite_is_known() -> None:
    assert find_suite("linear") is linear.run
