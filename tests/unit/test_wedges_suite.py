"""The wedges suite: its views, and a small run that leaves all figures and pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from softshadows.bench.suites import Settings, find_suite, wedges
from softshadows.bench.suites.wedges import View, growth, measure_view
from softshadows.compare.comparison import file_stem
from softshadows.compare.console import figures_table
from softshadows.techniques import make_technique

SIZE = (48, 36)


def test_the_views() -> None:
    views = list(wedges.views())
    assert [view.count for view in views] == [1, 2, 3, 4]
    assert all(view.techniques[0] == make_technique("penumbra_wedges", {"blending": "additive"}) for view in views)
    names = {technique.name for technique in views[2].techniques}
    assert names == {"penumbra_wedges", "uniform", "adaptive"}
    assert find_suite("wedges") is wedges.run


def test_a_small_run(tmp_path: Path) -> None:
    blendings = [make_technique("penumbra_wedges", {"blending": name}) for name in ("additive", "overlap")]
    settings = Settings(SIZE, samples=64, repeats=1, folder=tmp_path)
    found = measure_view(View("small", 2, blendings), settings, lambda doing, share: None)
    standard, paper = found.results
    assert standard.figures["time_ratio"] == standard.figures["rmse_ratio"] == 1.0
    assert paper.figures["rmse_ratio"] < 0.5
    assert paper.figures["triangles"] == 8 * 762 + 2
    assert paper.figures["edges"] == 8 * 762 * 3 // 2 + 5
    assert len(found.shot.scene.lights) == 1
    picture = np.asarray(Image.open(tmp_path / "small" / f"{file_stem(standard.label)}-error.png"))
    assert picture.shape == (*SIZE[::-1], 3)
    assert figures_table(found) is not None
    grown = growth([found, found])
    assert grown["triangles"] == [6098] * 2
    assert grown["linear_within"] is None, "two points are always on a line"
