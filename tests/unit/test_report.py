"""Reports: figures from the right arrays, a page that holds everything and escapes names, JSON with a stable shape."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from softshadows import metrics
from softshadows.cli import app
from softshadows.errors import DeviceError, OptionError, SceneError
from softshadows.report import demo, suites
from softshadows.report.compare import file_stem, write_report
from softshadows.report.console import results_table
from softshadows.report.measure import Measurement, Reference, Result, label_of, measure
from softshadows.report.page import COLUMNS, page, row_values
from softshadows.report.plates import plates
from softshadows.report.results import SCHEMA, results, write_bytes
from softshadows.report.suites import baselines
from softshadows.report.turns import Timing
from softshadows.scene.shot import open_shot
from softshadows.techniques import make_technique

HEIGHT, WIDTH = 24, 32
ENVIRONMENT = {
    "adapter": {"adapter": "a <b>", "backend": "Vulkan", "driver": "d", "features": [], "fallbacks": [], "limits": {}},
    "cpu": "c",
    "cpu_count": 2,
    "system": "s",
    "versions": {"python": "3", "embreex": None},
    "commit": None,
}

TIMES = {"frame": Timing(1.5, 1.25, 2.0, 3)}


def made_up_measurement(lights: int = 1) -> Measurement:
    """Two techniques over a ramp from umbra to light, one exact and one too light by 0.05; no GPU."""
    truth = np.tile(np.clip(np.linspace(-1.0, 2.0, WIDTH, dtype=np.float32), 0, 1), (lights, HEIGHT, 1))
    mask = np.ones_like(truth, bool)
    picture = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    shot = replace(open_shot("blocker"), size=(WIDTH, HEIGHT), name="<script>alert(1)</script>")
    shot.scene.lights = shot.scene.lights * lights
    stats = {"shadow_maps": 9, "lookups_per_pixel": 9.0, "gpu_ms": {"lookup": 1.0}, "cpu_ms": 1.0, "gpu_bytes": 10}
    made = []
    for grid, offset in ((3, 0.0), (5, 0.05)):
        technique = make_technique("uniform", {"grid": grid})
        visibility = truth + np.float32(offset)
        comparisons = [metrics.compare(*light) for light in zip(visibility, truth, mask, strict=True)]
        made.append(
            Result(technique, label_of(technique), visibility, picture, comparisons, None, TIMES, stats, ["a & b"])
        )
    reference = Reference(truth, mask, picture, 0.0, samples=64, standard_error=0.01, seconds=0.5)
    return Measurement(shot, reference, made, ["vsm: cannot <do> it"])


@pytest.fixture(autouse=True)
def known_environment(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if "real" not in request.node.name:
        monkeypatch.setattr("softshadows.report.results.environment", lambda: ENVIRONMENT)


class Reader(HTMLParser):
    """Collects tags and image sources, to see that the page is whole and asks for nothing from outside."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.images: list[str] = []
        self.links: list[str] = []
        self.rows = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.rows += tag == "tr"
        if tag == "img":
            self.images.append(values["src"] or "")
        self.links += [values[key] or "" for key in ("href", "src") if key in values and tag != "img"]
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("lights", [1, 2])
def test_the_page_is_whole_and_holds_everything(lights: int) -> None:
    measurement = made_up_measurement(lights)
    text = page(measurement, plates(measurement), results([measurement]))
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert reader.links == []
    assert reader.rows == 1 + 2 * lights
    assert len(reader.images) == 2 * (2 + 3 * lights)
    assert all(source.startswith("data:image/png;base64,") for source in reader.images)
    assert "<script>" not in text
    assert "&lt;script&gt;" in text
    assert "vsm: cannot &lt;do&gt; it" in text
    assert all(heading in text for heading, _, _ in COLUMNS)


def test_figures_of_a_row() -> None:
    exact, light = made_up_measurement().results
    by_name = dict(zip([heading for heading, _, _ in COLUMNS], row_values(light, 0), strict=True))
    assert by_name["rmse"] == pytest.approx(0.05, abs=1e-6)
    assert by_name["bias"] == pytest.approx(0.05, abs=1e-6)
    assert by_name["FLIP"] is None
    assert row_values(exact, 0)[2] == 0.0


def test_report_files(tmp_path: Path) -> None:
    index = write_report(made_up_measurement(), tmp_path / "new" / "report")
    assert index.name == "index.html"
    data = json.loads((index.parent / "results.json").read_text())
    assert data["schema"] == SCHEMA
    (picture,) = data["pictures"]
    assert picture["size"] == [WIDTH, HEIGHT]
    assert picture["lights"][0]["type"] == "rect"
    assert picture["truth"]["samples"] == 64
    first = picture["techniques"][0]
    assert (first["label"], first["name"], first["options"]["grid"]) == ("uniform:grid=3", "uniform", 3)
    assert first["lights"][0]["rmse"] == 0.0
    assert first["frame_ms"] == 1.5
    assert first["times"] == {"frame": {"median_ms": 1.5, "fastest_ms": 1.25, "slowest_ms": 2.0, "frames": 3}}
    image = Image.open(index.parent / "images" / "uniform-grid-3-visibility.png")
    assert image.size == (WIDTH, HEIGHT)
    np.testing.assert_array_equal(np.asarray(image)[0, [0, -1]], [0, 255])


def test_results_are_plain_json() -> None:
    data = results([made_up_measurement(2)], suite="baselines")
    text = json.dumps(data, allow_nan=False)
    assert json.dumps(json.loads(text)) == text


def test_file_names_are_tame() -> None:
    assert file_stem("uniform:grid=9") == "uniform-grid-9"
    assert file_stem("../../etc") == "etc"
    assert file_stem("..") == "x"


def test_an_unwritable_place_is_an_option_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OptionError, match="file"):
        write_bytes(b"", tmp_path / "file" / "inside.png")


def test_the_table_has_a_row_per_technique() -> None:
    assert results_table([made_up_measurement(), made_up_measurement()]).row_count == 4


def test_suites() -> None:
    assert suites.find_suite("baselines") is baselines.run
    assert suites.describe("baselines")
    with pytest.raises(OptionError, match="baselines"):
        suites.find_suite("nothing")


def test_the_baselines_find_the_real_shots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(baselines.SCENES_VARIABLE, raising=False)
    built_in = list(baselines.sources())
    monkeypatch.setenv(baselines.SCENES_VARIABLE, str(tmp_path))
    with pytest.raises(SceneError, match="SOFTSHADOWS_SCENES"):
        list(baselines.sources())
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "one.toml").write_text('scene = "blocker"')
    assert list(baselines.sources()) == [*built_in, str(tmp_path / "shots" / "one.toml")]


def small_shot():
    return replace(open_shot("blocker"), size=(WIDTH, HEIGHT))


def test_measuring_nothing_is_refused() -> None:
    with pytest.raises(OptionError, match="technique"):
        measure(small_shot(), [])
    dark = small_shot()
    dark.scene.lights = []
    with pytest.raises(OptionError, match="light"):
        measure(dark, [make_technique("hard")])


def test_real_measurement_of_one_rectangle() -> None:
    seen: list[float] = []
    techniques = [make_technique("none"), make_technique("uniform", {"grid": 5}), make_technique("none")]
    measurement = measure(small_shot(), techniques, samples=64, repeats=1, notice=lambda _, share: seen.append(share))
    assert [result.label for result in measurement.results] == ["none", "uniform:grid=5"]
    nothing, uniform = measurement.results
    assert (nothing.visibility == 1.0).all()
    assert uniform.comparisons[0].rmse < nothing.comparisons[0].rmse / 3
    assert uniform.stats["shadow_maps"] == 25
    assert uniform.frame_ms > 0.0
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_real_failure_is_skipped_or_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object, **options: object) -> None:
        raise DeviceError("too little memory")

    monkeypatch.setattr("softshadows.report.turns.Renderer", fail)
    with pytest.raises(DeviceError):
        measure(small_shot(), [make_technique("hard")], samples=1)
    measurement = measure(small_shot(), [make_technique("hard")], samples=1, skip=True)
    assert measurement.results == []
    assert measurement.skipped == ["hard: too little memory"]


def test_real_commands_write_their_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.toml").write_text('scene = "blocker"\nsize = [32, 24]\n[technique]\nname = "uniform"\ngrid = 3\n')
    rendered = CliRunner().invoke(app, ["render", "shot.toml", "-O", "weights=equal", "-o", "a.png"])
    assert rendered.exit_code == 0, rendered.output
    assert "9 shadow maps" in rendered.output
    assert Image.open("a.png").size == (32, 24)
    arguments = ["compare", "shot.toml", "-t", "hard,uniform:grid=2", "--samples", "16", "--repeats", "1", "-o", "out"]
    compared = CliRunner().invoke(app, arguments)
    assert compared.exit_code == 0, compared.output
    labels = [t["label"] for t in json.loads(Path("out/results.json").read_text())["pictures"][0]["techniques"]]
    assert labels == ["hard", "uniform:grid=2"]
    assert Path("out/index.html").stat().st_size > 1000


def test_real_demo_writes_its_four_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(demo, "SIZE", (32, 24))
    monkeypatch.setattr(demo, "SAMPLES", 4)
    monkeypatch.setattr(demo, "SCENE", "blocker")
    monkeypatch.setattr(demo, "BESIDE", ("hard",))
    demo.main()
    for name in ("picture", "visibility", "truth", "error"):
        assert Image.open(tmp_path / "demo" / f"{name}.png").size == (32, 24)
    printed = capsys.readouterr().out
    assert "demo/visibility.png" in printed
    assert "uniform" in printed
