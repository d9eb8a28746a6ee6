"""benchmarks/results and docs/benchmarks.md: the files have the schema's shape, and the page is what they give."""

from __future__ import annotations

from pathlib import Path

import pytest

from softshadows.bench.benchmarks import IMAGES, benchmarks_page, committed_results
from softshadows.compare.schema import read_results

ROOT = Path(__file__).parents[2]


def test_the_committed_page_is_what_the_committed_results_give() -> None:
    page, charts = benchmarks_page([read_results(path) for path in committed_results(ROOT)])
    docs = ROOT / "docs"
    assert page == (docs / "benchmarks.md").read_text(encoding="utf-8"), "run `softshadows bench report` anew"
    committed = {path.name: path.read_text(encoding="utf-8") for path in (docs / IMAGES).glob("*.svg")}
    assert charts == committed


@pytest.mark.parametrize("path", committed_results(ROOT), ids=lambda path: path.stem)
def test_committed_results_are_of_their_suite_and_timed_often_enough(path: Path) -> None:
    data = read_results(path)
    assert data["suite"] == path.stem
    rows = [row for picture in data["pictures"] for row in picture["techniques"]]
    assert min(timing["frames"] for row in rows for timing in row["times"].values()) >= 3
