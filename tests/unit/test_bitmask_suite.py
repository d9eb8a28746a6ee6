"""The suite of bitmask: its views, and a small run that leaves all figures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from softshadows.bench.benchmarks import benchmarks_page
from softshadows.bench.suites import Settings, bitmask, find_suite
from softshadows.bench.suites.baselines import SCENES_VARIABLE
from softshadows.bench.suites.bitmask import measure_view
from softshadows.compare.results import results
from softshadows.errors import SceneError
from softshadows.scene.shot import open_shot


def test_the_views(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert find_suite("bitmask") is bitmask.run
    monkeypatch.delenv(SCENES_VARIABLE, raising=False)
    assert [view.name for view in bitmask.views()] == ["figures", "leaves"]
    monkeypatch.setenv(SCENES_VARIABLE, str(tmp_path))
    with pytest.raises(SceneError, match="SOFTSHADOWS_SCENES"):
        list(bitmask.views())


def test_a_small_run() -> None:
    measurement = measure_view(open_shot("blocker"), Settings((48, 36), 64, 1), lambda doing, share: None, (24, 18))
    assert not measurement.skipped
    assert 0 < measurement.figures["bits"] <= 24 * 18 * 256
    assert measurement.figures["differing"] == 0
    assert measurement.figures["farthest_from_edge"] is None
    assert measurement.figures["receivers"] == int(measurement.reference.mask.any(axis=0).sum())
    assert [entry["samples"] for entry in measurement.figures["rays"]] == list(bitmask.RAYS)
    by_label = {result.label: result.figures for result in measurement.results}
    assert len(by_label) == len(bitmask.TECHNIQUES)
    rows = [by_label[f"bitmask:rows={count}"] for count in (4, 16, 32)]
    rows.insert(1, by_label["bitmask"])
    adaptive = by_label["adaptive:visibility=ray"]
    for figures in rows:
        ratio = adaptive["redrawn"]["wall_ms"] / figures["redrawn"]["wall_ms"]
        assert figures["adaptive_ratio"] == pytest.approx(ratio)
        assert figures["boxes"] > figures["triangles"] > 0.0
    # Twice the rows are marked twice as often, and the walks of 16 and 32 rows are two and four.
    assert rows[1]["words"] == pytest.approx(2.0 * rows[0]["words"], rel=0.2)
    assert rows[3]["words"] == pytest.approx(2.0 * rows[2]["words"], rel=0.2)
    assert rows[3]["boxes"] > rows[2]["boxes"] > rows[1]["boxes"]
    assert "boxes" not in adaptive
    moved = {label for label, figures in by_label.items() if "moved_ms" in figures}
    assert moved == {"bitmask", "adaptive:visibility=ray"}
    data = json.loads(json.dumps(results([measurement], suite="bitmask"), allow_nan=False))
    page, _ = benchmarks_page([data])
    assert "| adaptive ratio |" in page
