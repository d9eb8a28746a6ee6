"""The suite of rays: its views, a small run that leaves all figures, and a disagreement that it must see."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from softshadows.bench.benchmarks import benchmarks_page
from softshadows.bench.suites import Settings, find_suite, rays
from softshadows.bench.suites.adaptive import FacingSurfaces
from softshadows.bench.suites.baselines import SCENES_VARIABLE
from softshadows.bench.suites.rays import View, cast_by_both, hills, measure_view
from softshadows.compare.results import results
from softshadows.errors import SceneError
from softshadows.scene.shot import open_shot
from softshadows.techniques import Adaptive
from softshadows.truth.gpu_occluders import GpuOccluders

SIZE = (48, 36)
SEGMENTS = 20_000


def test_the_views(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(SCENES_VARIABLE, raising=False)
    names = [view.name for view in rays.views()]
    assert names == [*rays.BUILTIN, "hills, 10000 triangles", "hills, 100000 triangles"]
    monkeypatch.setenv(SCENES_VARIABLE, str(tmp_path))
    with pytest.raises(SceneError, match="SOFTSHADOWS_SCENES"):
        list(rays.views())
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "scorpion.toml").write_text('scene = "blocker"')
    assert next(view.name for view in rays.views()) == "scorpion"


def test_a_small_run() -> None:
    view = View("small", lambda: open_shot("blocker"), rays.TECHNIQUES)
    measurement = measure_view(view, Settings(SIZE, 64, 1), lambda doing, share: None, SEGMENTS)
    assert not measurement.skipped
    figures = measurement.figures
    assert figures["segments"] >= SEGMENTS
    assert figures["ratio"] == pytest.approx(figures["gpu_per_second"] / figures["embree_per_second"])
    assert figures["disagreeing"] == 0
    assert figures["farthest_from_edge"] is None
    by_label = {result.label: result.figures for result in measurement.results}
    assert len(by_label) == len(rays.TECHNIQUES)
    uniform, hybrid = (
        by_label["uniform:grid=9:visibility=ray"],
        by_label["uniform:grid=9:visibility=hybrid:resolution=512"],
    )
    assert uniform["lookups"] == hybrid["lookups"] == 81.0
    assert hybrid["rmse_over_rays"] == pytest.approx(hybrid["rmse_truth"] / uniform["rmse_truth"])
    assert hybrid["time_over_rays"] == pytest.approx(hybrid["cached"]["wall_ms"] / uniform["cached"]["wall_ms"])
    receivers = int(measurement.reference.mask.sum())
    for each in by_label.values():
        cast_ms = 1e3 * each["equal_rays"] * receivers / figures["embree_per_second"]
        dynamic = (figures["embree_build_ms"] + cast_ms) / each["redrawn"]["wall_ms"]
        assert each["dynamic_ratio"] == pytest.approx(dynamic)
        assert 0.0 < each["rmse_truth"] < 0.1
    data = json.loads(json.dumps(results([measurement], suite="rays"), allow_nan=False))
    page, _ = benchmarks_page([data])
    assert f"| ratio | {figures['ratio']:.3g} |" in page


def test_hills_tell_how_long_trees_take() -> None:
    view = View("hills", lambda: hills("hills", 500), (Adaptive(visibility="ray"),), times_trees=True)
    figures = measure_view(view, Settings(SIZE, 16, 1), lambda doing, share: None, SEGMENTS).figures
    assert figures["cpu_build_ms"] > figures["cpu_refit_ms"] > 0.0
    assert figures["gpu_build_ms"] > 0.0
    assert [entry["samples"] for entry in figures["rays"]] == list(rays.RAYS)


def test_a_wrong_answer_is_seen_and_is_far_from_an_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = GpuOccluders.blocked_from

    def wrong(self: GpuOccluders, *segments: Any) -> np.ndarray:
        blocked = honest(self, *segments)
        blocked[0, 0] ^= True
        return blocked

    monkeypatch.setattr(GpuOccluders, "blocked_from", wrong)
    shot = hills("hills", 2)
    above = np.array([[[0.0, 1.0, 0.0]]], np.float32)
    figures = cast_by_both(shot, FacingSurfaces(above, above, np.ones((1, 1), bool)), 16)
    assert figures["disagreeing"] == 1
    assert figures["farthest_from_edge"] == 1.0


def test_the_suite_is_known() -> None:
    assert find_suite("rays") is rays.run
