"""The benchmark page: made-up results stand where they should."""

from __future__ import annotations

import copy
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from test_schema import made_up
from typer.testing import CliRunner

from softshadows.bench.benchmarks import IMAGES, benchmarks_page, committed_results
from softshadows.bench.charts import COLOURS, Mark, chart
from softshadows.cli.app import app
from softshadows.errors import OptionError

SVG = "{http://www.w3.org/2000/svg}"


def with_pictures(count: int, **figures: object) -> dict:
    """`count` pictures of two techniques."""
    data = made_up()
    (picture,) = data["pictures"]
    picture["techniques"][0]["figures"] = figures
    other = copy.deepcopy(picture["techniques"][0])
    other["label"], other["lights"][0]["rmse"], other["frame_ms"] = "pcf", 0.0, 123.4
    picture["techniques"].append(other)
    data["pictures"] = [copy.deepcopy({**picture, "scene": f"view {index}"}) for index in range(count)]
    return data


def test_a_table_per_picture() -> None:
    page, charts = benchmarks_page([with_pictures(1, reads=3.14159, kind="soft", redrawn={"wall_ms": 1.0})])
    assert "| `hard` | 2.00 (1.00–3.00) | 0.0100 | 1.00% | 1.00% | 1 | 1.0 | 0 |" in page
    assert "| `pcf` | 123 (1.00–3.00) | 0.0000 |" in page
    assert "| technique | reads | kind |\n| --- | ---: | ---: |\n| `hard` | 3.14 | soft |" in page
    assert list(charts) == ["mine-error-against-time.svg"]
    assert "(images/benchmarks/mine-error-against-time.svg)" in page


def test_a_matrix_where_all_pictures_show_the_same() -> None:
    page, _ = benchmarks_page([with_pictures(3)])
    assert "| rmse | `hard` | `pcf` |\n| --- | ---: | ---: |\n| view 0, 4 triangles | 0.0100 | 0.0000 |" in page
    assert "### view" not in page


def test_what_grows_is_drawn_over_its_amount() -> None:
    data = with_pictures(2, series="hard", amount=1)
    for index, picture in enumerate(data["pictures"]):
        picture["figures"] = {"axis": "lights"}
        for row in picture["techniques"]:
            row["figures"] = {"series": row["label"], "amount": 2**index}
    page, charts = benchmarks_page([data])
    assert list(charts) == ["mine-lights-time.svg", "mine-lights-memory.svg"]
    assert "### lights" in page
    assert charts["mine-lights-time.svg"].count("<polyline") == 2


def test_words_stand_below_the_table_and_what_is_left_out_is_named() -> None:
    data = with_pictures(1, about="It has no area lights.")
    data["pictures"][0]["skipped"] = ["three: it is not there"]
    page, _ = benchmarks_page([data])
    assert "- **hard** (): It has no area lights." in page
    assert "| `hard` | 2.00 (1.00–3.00) | 0.0100 | 1.00% | 1.00% | – | – | – |" in page
    assert "- view 0: three: it is not there" in page


def test_a_chart_places_marks_on_logarithmic_axes() -> None:
    marks = [Mark(1.0, 10.0, "a <b>"), Mark(10.0, 100.0, "c"), Mark(100.0, 1000.0, "d")]
    text = chart({"one": marks, "two & more": marks[:1]}, "x", "y", joined=True)
    assert text == chart({"one": marks, "two & more": marks[:1]}, "x", "y", joined=True)
    root = ElementTree.fromstring(text)
    dots = [
        (float(dot.get("cx", "")), float(dot.get("cy", "")))
        for dot in root.iter(f"{SVG}circle")
        if dot.get("fill") == COLOURS[0]
    ][:3]
    assert dots[1][0] - dots[0][0] == pytest.approx(dots[2][0] - dots[1][0], abs=0.11)
    assert dots[1][1] - dots[0][1] == pytest.approx(dots[2][1] - dots[1][1], abs=0.11)
    assert dots[0][0] < dots[2][0]
    assert dots[0][1] > dots[2][1]
    texts = [element.text for element in root.iter(f"{SVG}text")]
    assert texts[-2:] == ["one", "two & more"]
    assert next(title.text for title in root.iter(f"{SVG}title")) == "a <b>"


def test_the_command_writes_page_and_charts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.json").write_text(json.dumps(with_pictures(1)))
    done = CliRunner().invoke(app, ["bench", "report", "mine.json", "-o", "out/page.md"])
    assert done.exit_code == 0, done.output
    page, charts = benchmarks_page([with_pictures(1)])
    assert Path("out/page.md").read_text() == page
    for name, text in charts.items():
        assert Path("out", IMAGES, name).read_text() == text


def test_a_folder_without_results_is_named(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="holds no results"):
        committed_results(tmp_path)
