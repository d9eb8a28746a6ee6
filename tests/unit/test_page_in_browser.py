"""The compare page in a browser: it opens, draws what was measured, follows keys and pointer, and asks for nothing."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

import made_up
from softshadows import metrics
from softshadows.compare.page import page as page_text

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.chromium

FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
DATA = {"environment": made_up.ENVIRONMENT, "created": "2026-01-01T00:00:00+00:00"}
EXACT, LIGHT = "uniform:grid=3", "uniform:grid=5"

SAMPLES = """(canvas, [rows, columns]) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const at = (share, extent) => Math.floor(share * extent);
    return rows.map((y) => columns.map((x) =>
        Array.from(copy.getImageData(at(x, canvas.width), at(y, canvas.height), 1, 1).data)));
}"""
"""Colours of a canvas at shares of its height and width."""

MIDDLES = (
    ((np.arange(made_up.HEIGHT) + 0.5) / made_up.HEIGHT).tolist(),
    ((np.arange(made_up.WIDTH) + 0.5) / made_up.WIDTH).tolist(),
)
"""Where a canvas shows the middle of every pixel of the whole picture."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install playwright")
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None:
        pytest.skip("no Chromium on this machine: install the package chromium")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield started
        started.close()


@pytest.fixture
def page(browser: Browser, tmp_path: Path) -> Iterator[Page]:
    """The page of two pictures, one with two lights. Whatever a script complains of, or asks for, fails the test."""
    file = tmp_path / "index.html"
    file.write_text(page_text([made_up.measurement(name="one"), made_up.measurement(2, name="two")], DATA), "utf-8")
    opened = browser.new_page(viewport={"width": 1200, "height": 900})
    complaints: list[str] = []
    requests: list[str] = []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: requests.append(request.url))
    opened.goto(file.as_uri())
    wait(opened)
    yield opened
    opened.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith("data:")] == [file.as_uri()]


def wait(page: Page) -> None:
    """Until the stage is painted."""
    page.wait_for_selector("#stage[aria-busy=false]")


def drawn(page: Page, index: int, where: tuple[list[float], list[float]] = MIDDLES) -> npt.NDArray[np.uint8]:
    """(rows, columns, 3): colours of one of the stage's canvases, in the order in which they stand."""
    wait(page)
    return np.array(page.locator("#stage canvas").nth(index).evaluate(SAMPLES, list(where)), np.uint8)[..., :3]


def choose(page: Page, left: str, right: str, mode: str = "side", layer: str = "visibility") -> None:
    page.select_option("#left", label=left)
    page.select_option("#right", label=right)
    page.check(f"[name=mode][value={mode}]")
    if mode == "slider":
        page.select_option("#layer", layer)
    wait(page)


def test_side_by_side_shows_picture_visibility_error_and_truth(page: Page) -> None:
    """Every pixel of visibility, truth and error is what numpy makes of it, at several amplifications."""
    measured = made_up.measurement()
    truth, visibility = measured.reference.visibility[0], measured.results[1].visibility[0]
    choose(page, LIGHT, "truth")
    captions = page.locator("#stage figcaption").all_text_contents()
    assert captions == [
        f"{LIGHT}: picture",
        f"{LIGHT}: visibility",
        f"{LIGHT}: error",
        "truth: picture",
        "truth: visibility",
    ]
    assert (drawn(page, 0) == 128).all()
    for index, image in ((1, visibility), (4, truth)):
        expected = np.rint(255 * np.clip(image, 0, 1))[..., None]
        np.testing.assert_allclose(drawn(page, index).astype(int), np.broadcast_to(expected, (24, 32, 3)), atol=1)
    for step, gain in ((0, 1.0), (20, 10.0), (50, 10**2.5)):
        page.locator("#gain").evaluate(
            "(range, step) => { range.value = step; range.dispatchEvent(new Event('input')); }", step
        )
        shown = np.clip(visibility, 0, 1)
        expected = 255 * metrics.signed_error_image(shown, truth, measured.reference.mask[0], amplification=gain)
        np.testing.assert_allclose(drawn(page, 2).astype(float), expected, atol=2)


def test_the_slider_moves_by_keys_and_by_pointer(page: Page) -> None:
    choose(page, EXACT, LIGHT, "slider", "error")
    canvas = page.locator("#stage canvas")
    assert canvas.count() == 1

    def right_of() -> float:
        """The first share of the width at which the picture on the right, which errs, is seen."""
        shares = np.linspace(0.0, 0.999, 500)
        (row,) = drawn(page, 0, ([0.2], shares.tolist())).astype(int)
        coloured = np.flatnonzero(row[:, 0] - row[:, 2] > 5)
        return float(shares[coloured[0]]) if len(coloured) else 1.0

    assert right_of() == pytest.approx(0.5, abs=0.01)
    page.focus("#split")
    for _ in range(50):
        page.keyboard.press("ArrowLeft")
    assert right_of() == pytest.approx(0.45, abs=0.01)
    page.keyboard.press("End")
    assert right_of() > 0.99
    page.keyboard.press("Home")
    assert right_of() < 0.35, "the right picture errs from the first column of the penumbra on"
    page.locator("#split").fill("500")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 50, steps=4)
    page.mouse.up()
    assert right_of() == pytest.approx(0.6, abs=0.01)
    assert page.locator("#split").input_value() == "600"


def test_all_pictures_move_together(page: Page) -> None:
    """Keys, buttons, wheel and pointer: two rows of one technique stay equal, and what they show changes each time."""
    choose(page, LIGHT, LIGHT)
    page.focus("#stage")
    box = page.locator("#stage canvas").nth(1).bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 3

    def drag() -> None:
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 30, y, steps=3)
        page.mouse.up()

    def wheel() -> None:
        page.mouse.move(x, y)
        page.keyboard.down("Control")
        page.mouse.wheel(0, -100)
        page.keyboard.up("Control")
        page.wait_for_timeout(100)

    seen = [drawn(page, 1)]
    steps = [
        lambda: page.keyboard.press("+"),
        lambda: page.keyboard.press("ArrowRight"),
        lambda: page.keyboard.press("-"),
        lambda: page.click("#closer"),
        lambda: page.click("#worst"),
        wheel,
        drag,
        lambda: page.click("#whole"),
    ]
    for step in steps:
        step()
        seen.append(drawn(page, 1))
        np.testing.assert_array_equal(seen[-1], drawn(page, 4))
        assert not np.array_equal(seen[-1], seen[-2])
    np.testing.assert_array_equal(seen[-1], seen[0])


def test_the_pointer_reads_figures(page: Page) -> None:
    choose(page, LIGHT, "truth")
    box = page.locator("#stage canvas").nth(1).bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 1, box["y"] + 1)
    page.locator("#readout", has_text="column").wait_for()
    said = page.locator("#readout").text_content() or ""
    assert said.startswith("column 0, row 0, light 0, rect: truth 0.0000")
    assert f"{LIGHT} 0.0500 (+0.0500)" in said


def test_pictures_lights_and_worst_regions_are_chosen(page: Page) -> None:
    assert page.locator("#light").is_hidden()
    page.select_option("#picture", label="two")
    wait(page)
    assert page.locator("#light option").count() == 2
    button = page.locator(".worst[data-picture='1'][data-light='1'] button").last
    button.scroll_into_view_if_needed()
    crops = page.locator(".worst[data-picture='1'][data-light='1'] canvas")
    crops.nth(2).and_(page.locator("[width='24']")).wait_for()
    colours = np.array(crops.nth(2).evaluate(SAMPLES, list(MIDDLES)))
    assert (colours[..., 0] > colours[..., 2]).any(), "it is too light: an error map of orange"
    button.click()
    wait(page)
    assert page.locator("#picture").evaluate("s => s.selectedOptions[0].text") == "two"
    assert page.locator("#light").input_value() == "1"
    assert page.locator("#left").evaluate("s => s.selectedOptions[0].text") == LIGHT


def test_everybody_can_use_it(page: Page) -> None:
    """Every control has a name, every canvas a description; text is legible in light and dark."""
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("select, input, button")].filter((control) =>
            !(control.labels && control.labels.length) && !control.getAttribute("aria-label")
            && !control.textContent.trim()).map((control) => control.id)"""
    )
    assert nameless == []
    canvases = page.locator("#stage canvas")
    assert all("one" in (canvases.nth(i).get_attribute("aria-label") or "") for i in range(canvases.count()))
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        paper, ink = (
            np.array([int(part) for part in text.strip("rgba()").split(",")[:3]])
            for text in page.evaluate(
                "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
            )
        )
        assert abs(paper.mean() - ink.mean()) > 180, scheme
