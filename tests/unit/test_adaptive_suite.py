"""The adaptive suite: its views, the rays that equal an error, and a small run that leaves all figures and pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from softshadows.bench.suites import Settings, adaptive, baselines, find_suite
from softshadows.bench.suites.adaptive import Rays, View, measure_view
from softshadows.compare.console import figures_table
from softshadows.compare.measure import label_of
from softshadows.compare.results import results
from softshadows.errors import SceneError
from softshadows.scene.shot import open_shot
from softshadows.techniques import make_technique

SIZE = (48, 36)


def test_rays_of_equal_error_are_interpolated() -> None:
    samples = [4, 16, 64, 256]
    rays = Rays(samples, [0.4 / n for n in samples], [0.5 + 0.01 * n for n in samples])
    for wanted in (4.0, 10.0, 100.0, 256.0):
        assert rays.equal_to(0.4 / wanted) == (pytest.approx(wanted), None)
    assert rays.equal_to(1.0) == (4.0, "at most")
    assert rays.equal_to(0.0) == (256.0, "at least")
    assert rays.ms_per_sample == pytest.approx(10.0)


def test_rays_that_do_not_converge_evenly() -> None:
    rays = Rays([4, 9, 16], [0.2, 0.3, 0.1], [1.0, 0.9, 0.8])
    assert rays.equal_to(0.2) == (4.0, None)
    assert 4.0 < rays.equal_to(0.15)[0] < 16.0
    assert rays.ms_per_sample == pytest.approx(50.0)


def test_the_views(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(baselines.SCENES_VARIABLE, raising=False)
    assert [view.name for view in adaptive.views()] == ["far", "near", "atrium"]
    for view in adaptive.views():
        assert view.open().scene.lights
        assert all(group[0].name == "uniform" for group in view.groups)
    monkeypatch.setenv(baselines.SCENES_VARIABLE, str(tmp_path))
    with pytest.raises(SceneError, match="SOFTSHADOWS_SCENES"):
        list(adaptive.views())
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "body.toml").write_text('scene = "blocker"')
    *_, last = adaptive.views()
    assert last.name == "body"
    assert last.open().name == "body"


def test_a_small_run(tmp_path: Path) -> None:
    uniform = make_technique("uniform", {"resolution": 128, "grid": 9})
    tree = make_technique("adaptive", {"resolution": 128, "max_depth": 2})
    view = View("small", lambda: open_shot("blocker"), [[uniform, tree], [make_technique("uniform", {"grid": 2})]])
    lights = view.open().scene.lights
    measurement = measure_view(view, Settings(SIZE, 256, 1, tmp_path), lambda doing, share: None)
    assert [result.label for result in measurement.results] == [label_of(t) for group in view.groups for t in group]
    assert measurement.shot.scene.lights == lights
    first, second, third = (result.figures for result in measurement.results)
    assert first["time_ratio_redrawn"] == first["time_ratio_cached"] == 1.0
    assert first["rmse_uniform"] == 0.0
    assert 0.0 < second["rmse_uniform"] < 0.05
    assert second["rmse_truth"] == measurement.results[1].comparisons[0].rmse
    assert second["redrawn"]["wall_ms"] == measurement.results[1].frame_ms
    assert second["lookups"] <= 25.0
    assert third["cached"] is None
    assert third["time_ratio_cached"] is None
    assert 4.0 <= third["equal_rays"] < first["equal_rays"]
    assert [entry["samples"] for entry in measurement.figures["rays"]] == list(adaptive.RAYS)

    data = json.loads(json.dumps(results([measurement], suite="adaptive"), allow_nan=False))
    assert data["pictures"][0]["techniques"][1]["figures"] == second
    assert data["pictures"][0]["figures"]["rays"]
    table = figures_table(measurement)
    assert table is not None
    assert table.row_count == len(second) - 2  # without the dicts by pass
    assert len(table.columns) == 1 + 3

    stem = tmp_path / "small" / "adaptive-max-depth-2-resolution-128"
    picture, few, many = (
        np.asarray(Image.open(f"{stem}{end}.png")) for end in ("", "-difference-x5", "-difference-x40")
    )
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    np.testing.assert_array_equal(np.minimum(8 * few.astype(int), 255), many)
    for name in ("light", "light-of-tile", "comparison", "lookups"):
        assert Path(f"{stem}-{name}.png").exists()
    assert (tmp_path / "small" / "truth.png").exists()


def test_the_suite_is_known() -> None:
    assert find_suite("adaptive") is adaptive.run
