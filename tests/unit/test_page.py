"""The compare page: whole, self-contained, escaped; the tables, the plot, and what the explorer unpacks."""

from __future__ import annotations

import base64
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np
import pytest

import made_up
from softshadows.compare.measure import Measurement
from softshadows.compare.page import page
from softshadows.compare.page.payload import FULL, pack_mask, pack_visibility, payload
from softshadows.compare.page.plot import Point, pareto_front, plot
from softshadows.compare.page.tables import COLUMNS, overall_table
from softshadows.techniques import TECHNIQUES
from softshadows.techniques.manual import sentence

DATA = {"environment": made_up.ENVIRONMENT, "created": "2026-01-01T00:00:00+00:00"}
VOID = ("meta", "input")


class Reader(HTMLParser):
    """Collects tags, to see that the page is whole and asks for nothing from outside."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.outside: list[str] = []
        self.rows = 0
        self.unlabelled: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.rows += tag == "tr"
        self.outside += [value or "" for key, value in attrs if key in ("href", "src", "action", "srcset")]
        if tag in ("canvas", "svg") and not values.get("aria-label"):
            self.unlabelled.append(tag)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """SVG's closed elements."""

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def page_of(*measurements: Measurement) -> str:
    return page(measurements, DATA)


@pytest.mark.parametrize("lights", [1, 2])
def test_the_page_is_whole_and_holds_everything(lights: int) -> None:
    text = page_of(made_up.measurement(lights))
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert reader.outside == []
    assert reader.unlabelled == []
    assert not re.search(r"https?://", text)
    passes = 2 * 2  # a table of two rows for each technique
    assert reader.rows == 1 + 2 * lights + passes
    assert "<script>alert" not in text
    assert "&lt;script&gt;" in text
    assert "vsm: cannot &lt;do&gt; it" in text
    assert "<li>a &amp; b</li>" in text
    assert all(column.heading in text for column in COLUMNS)
    assert sentence(TECHNIQUES["uniform"], "Fails when").split("`")[0] in text


def test_several_pictures_are_on_one_page() -> None:
    one, two = made_up.measurement(name="one"), made_up.measurement(name="two")
    text = page_of(one, two)
    assert all(f"<h2>{name}</h2>" in text for name in ("one", "two", "All pictures together"))
    assert text.count("<svg") == 2
    assert overall_table([one]) == ""
    only = Measurement(two.shot, two.reference, two.results[:1])
    assert "uniform:grid=5" not in overall_table([one, only]), "a mean over all pictures needs all of them"


def test_figures_of_a_row() -> None:
    exact, light = made_up.measurement().results
    values = {column.heading: column.value(light, 0) for column in COLUMNS}
    assert values["rmse"] == pytest.approx(made_up.OFFSET, abs=1e-6)
    assert values["bias"] == pytest.approx(made_up.OFFSET, abs=1e-6)
    assert (values["ms"], values["ms at rest"], values["GPU ms"]) == (1.5, 1.0, 1.0)
    assert values["FLIP"] is None
    assert next(column.value(exact, 0) for column in COLUMNS if column.heading == "rmse") == 0.0


def test_the_best_is_bold_within_its_light() -> None:
    text = page_of(made_up.measurement(2))
    rows = [re.findall(r"<td[^>]*>[^<]*", row) for row in re.findall(r'<tr><th scope="row">uniform.*?</tr>', text)]
    rmse = [column.heading for column in COLUMNS].index("rmse")
    assert [row[rmse] for row in rows] == ["<td class=best>0.0000", "<td>0.0500"] * 2


def test_pareto_front() -> None:
    fast, good, both_worse, same_error = Point("a", 1, 0.3), Point("b", 4, 0.1), Point("c", 5, 0.2), Point("d", 6, 0.1)
    assert pareto_front([same_error, both_worse, good, fast]) == [fast, good]
    assert pareto_front([]) == []


def test_the_plot_marks_the_front() -> None:
    made = made_up.measurement(name="one")
    text = plot(made)
    assert text.count('class="best"') == 2, "one is faster, the other exact"
    made.results[0].times["frame"] = made.results[1].times["frame"]
    assert plot(made).count('class="best"') == 1
    assert "closer to the truth: uniform:grid=3." in plot(made)
    assert "nan" not in text.lower()


def unpacked(text: str) -> np.ndarray:
    """What page.js does, in numpy."""
    stored = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, -1).astype(np.int64)
    zigzag = stored[0] * 256 + stored[1]
    steps = np.where(zigzag & 1, -((zigzag + 1) >> 1), zigzag >> 1)
    return np.cumsum(steps) % 65536


def test_visibility_is_packed_to_sixteen_bits() -> None:
    """All steps there are, both extremes beside each other, values outside 0..1 clipped."""
    random = np.random.default_rng(0)
    image = random.uniform(0.0, 1.0, (40, 50)).astype(np.float32)
    image[0, :6] = [0.0, 1.0, 0.0, 1.0, -0.5, 1.5]
    found = unpacked(pack_visibility(image)).reshape(image.shape) / FULL
    np.testing.assert_allclose(found, np.clip(image, 0, 1), atol=0.5 / FULL + 1e-7)


def test_a_mask_is_packed_to_bits() -> None:
    mask = np.random.default_rng(1).uniform(size=(5, 7)) < 0.5
    bits = np.unpackbits(np.frombuffer(zlib.decompress(base64.b64decode(pack_mask(mask))), np.uint8))
    np.testing.assert_array_equal(bits[: mask.size].reshape(mask.shape), mask)


def test_the_payload_is_json_and_cannot_end_its_script() -> None:
    made = made_up.measurement(2)
    data = payload([made])
    json.dumps(data, allow_nan=False)
    (picture,) = data["pictures"]
    assert picture["best"] == 0
    exact, light = picture["techniques"]
    assert exact["worst"] == [None, None]
    assert light["worst"][0] == [0, 0, 24, 24], "the first of equals"
    script = page_of(made).split('id="report">')[1].split("</script>")[0]
    assert json.loads(script) == json.loads(json.dumps(data))
