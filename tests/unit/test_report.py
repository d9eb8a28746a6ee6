"""Reports: figures from the right arrays, files in their places, JSON with a stable shape."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import made_up
from softshadows.bench import suites
from softshadows.bench.suites import baselines
from softshadows.cli import demo
from softshadows.cli.app import app
from softshadows.compare.comparison import file_stem, write_report
from softshadows.compare.console import results_table
from softshadows.compare.measure import measure
from softshadows.compare.results import results, write_bytes
from softshadows.compare.schema import RESULTS, check, read_results
from softshadows.errors import DeviceError, OptionError, SceneError
from softshadows.scene.shot import open_shot
from softshadows.techniques import make_technique


@pytest.fixture(autouse=True)
def known_environment(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if "real" not in request.node.name:
        monkeypatch.setattr("softshadows.compare.results.environment", lambda: made_up.ENVIRONMENT)


def test_report_files(tmp_path: Path) -> None:
    index = write_report([made_up.measurement(name="one/two")], tmp_path / "new" / "report")
    assert index.name == "index.html"
    data = read_results(index.parent / "results.json")
    (picture,) = data["pictures"]
    assert picture["size"] == [made_up.WIDTH, made_up.HEIGHT]
    assert picture["lights"][0]["type"] == "rect"
    assert picture["truth"]["samples"] == 64
    first = picture["techniques"][0]
    assert (first["label"], first["name"], first["options"]["grid"]) == ("uniform:grid=3", "uniform", 3)
    assert first["lights"][0]["rmse"] == 0.0
    image = Image.open(index.parent / "images" / "one-two" / "uniform-grid-3-visibility.png")
    assert image.size == (made_up.WIDTH, made_up.HEIGHT)
    np.testing.assert_array_equal(np.asarray(image)[0, [0, -1]], [0, 255])


def test_results_are_plain_json() -> None:
    data = results([made_up.measurement(2)], suite="baselines")
    text = json.dumps(data, allow_nan=False)
    assert json.dumps(json.loads(text)) == text
    check(json.loads(text), RESULTS)


def test_file_names_are_tame() -> None:
    assert file_stem("uniform:grid=9") == "uniform-grid-9"
    assert file_stem("../../etc") == "etc"
    assert file_stem("..") == "x"


def test_an_unwritable_place_is_an_option_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OptionError, match="file"):
        write_bytes(b"", tmp_path / "file" / "inside.png")


def test_the_table_has_a_row_per_technique() -> None:
    assert results_table([made_up.measurement(), made_up.measurement()]).row_count == 4


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
    return replace(open_shot("blocker"), size=(32, 24))


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

    monkeypatch.setattr("softshadows.compare.interleaved.Renderer", fail)
    with pytest.raises(DeviceError):
        measure(small_shot(), [make_technique("hard")], samples=1)
    measurement = measure(small_shot(), [make_technique("hard")], samples=1, skip=True)
    assert measurement.results == []
    assert measurement.skipped == ["hard: too little memory"]


def test_real_render_writes_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.toml").write_text('scene = "blocker"\nsize = [32, 24]\n[technique]\nname = "uniform"\ngrid = 3\n')
    rendered = CliRunner().invoke(app, ["render", "shot.toml", "-O", "weights=equal", "-o", "a.png"])
    assert rendered.exit_code == 0, rendered.output
    assert "9 shadow maps" in rendered.output
    assert Image.open("a.png").size == (32, 24)


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
    assert repr(demo.SHOWN) in printed
