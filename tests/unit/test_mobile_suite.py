"""The mobile suite: its rows, and a small run that leaves all figures and pictures."""

from __future__ import annotations

from pathlib import Path

from softshadows.bench.suites import Settings, find_suite, mobile
from softshadows.scene import builtin
from softshadows.scene.geometry import flatten
from softshadows.scene.shot import Shot
from softshadows.techniques import make_technique

SIZE = (96, 72)


def test_the_rows_are_the_papers() -> None:
    rows = mobile.techniques()
    assert rows[0] == make_technique("pcf", {"kernel": 4, "pattern": "poisson"})
    assert len(set(rows)) == len(rows) == 14
    assert find_suite("mobile") is mobile.run


def test_the_figure_has_the_papers_vertices() -> None:
    assert len(flatten(builtin.mannequin()).positions) > 50_000


def test_a_small_run(tmp_path: Path) -> None:
    scene = builtin.mannequin()
    assert scene.camera is not None
    rows = [row for row in mobile.techniques() if getattr(row, "resolution", 0) == 1024]
    settings = Settings(SIZE, samples=64, repeats=1, folder=tmp_path)
    found = mobile.measure_tables(Shot("mannequin", scene, scene.camera, SIZE), rows, settings, lambda *_: None)
    by_label = {result.label: result for result in found.results}
    plain = found.results[0]
    assert plain.figures["time_ratio"] == plain.figures["reads_ratio"] == plain.figures["filter_ratio"] == 1.0
    assert plain.figures["filter_ms"] == plain.figures["lookup_ms"] > 0.0
    fixed = by_label["variable_penumbra:kernels=fixed"].figures
    assert fixed["reads_ratio"] <= 1 / 3
    bands, light = by_label["variable_penumbra"], by_label["variable_penumbra:kernels=from_light"]
    pcss = by_label["pcss:blocker_samples=16:filter_samples=24"]
    assert light.comparisons[0].rmse <= 0.7 * bands.comparisons[0].rmse
    assert light.comparisons[0].rmse <= 1.0 * pcss.comparisons[0].rmse
    assert len(list((tmp_path / "far").glob("*.png"))) == len(rows)
