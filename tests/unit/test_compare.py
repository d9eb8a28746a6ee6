"""A comparison: several pictures, measurements that are kept and reused, a foreseen end."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from softshadows.cli.app import app
from softshadows.compare import comparison
from softshadows.compare.cache import MeasurementCache, digest
from softshadows.compare.comparison import Effort, Picture, compare
from softshadows.compare.console import time_left
from softshadows.compare.measure import Measurement
from softshadows.compare.schedule import Schedule
from softshadows.compare.schema import read_results
from softshadows.errors import DeviceError, OptionError
from softshadows.scene.lights import DirectionalLight, LineLight
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Technique, make_technique

EFFORT = Effort(samples=16, repeats=1)
LINE = LineLight(start=(-1, 4, 0), end=(1, 4, 0), radiance=(1, 1, 1))
HARD, UNIFORM = make_technique("hard"), make_technique("uniform", {"grid": 3})


def small_shot(name: str = "blocker") -> Shot:
    return replace(open_shot(name), size=(32, 24))


def run(kept: MeasurementCache, *pictures: Picture) -> tuple[list[Measurement], list[str]]:
    """The measurements, and what was said to be done."""
    said: list[str] = []
    return compare(pictures, EFFORT, lambda doing, share: said.append(doing), kept), said


def test_an_interrupted_comparison_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted in its second technique, only that one is rendered again, and the figures are those of one run."""
    picture = Picture(small_shot(), [HARD, UNIFORM])
    whole, _ = run(MeasurementCache(tmp_path / "whole"), picture)

    rendered = comparison._rendered

    def interrupted(shot: Shot, technique: Technique, *rest):
        if technique == UNIFORM:
            raise KeyboardInterrupt
        return rendered(shot, technique, *rest)

    monkeypatch.setattr(comparison, "_rendered", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(MeasurementCache(tmp_path / "cache"), picture)
    monkeypatch.setattr(comparison, "_rendered", rendered)

    resumed, said = run(MeasurementCache(tmp_path / "cache"), picture)
    assert any("uniform" in doing for doing in said)
    assert not any("hard" in doing or "tracing" in doing for doing in said)
    for one, other in zip(whole[0].results, resumed[0].results, strict=True):
        np.testing.assert_array_equal(one.visibility, other.visibility)
        assert one.comparisons == other.comparisons
        assert one.flip == other.flip
        assert one.stats["shadow_maps"] == other.stats["shadow_maps"]

    _, said = run(MeasurementCache(tmp_path / "cache"), picture)
    assert [doing for doing in said if "hard" in doing or "uniform" in doing or "tracing" in doing] == []
    _, said = run(MeasurementCache(tmp_path / "cache", fresh=True), picture)
    assert any("hard" in doing for doing in said)


CHANGES = {
    "camera": lambda shot: replace(shot, camera=replace(shot.camera, vertical_fov=20.0)),
    "size": lambda shot: replace(shot, size=(24, 24)),
    "light": lambda shot: with_light(shot, replace(shot.scene.lights[0], width=0.1)),
    "geometry": lambda shot: with_moved_vertex(shot),
}


def with_light(shot: Shot, light) -> Shot:
    shot.scene.lights = [light]
    return shot


def with_moved_vertex(shot: Shot) -> Shot:
    shot.scene.nodes[0].mesh.positions[0, 0] += 1e-3
    return shot


@pytest.mark.parametrize("change", CHANGES)
def test_what_is_kept_of_another_picture_is_not_used(tmp_path: Path, change: str) -> None:
    kept = MeasurementCache(tmp_path)
    run(kept, Picture(small_shot(), [HARD]))
    assert kept.frame(small_shot(), HARD, EFFORT.repeats, EFFORT.profile) is not None
    changed = CHANGES[change](small_shot())
    assert kept.frame(changed, HARD, EFFORT.repeats, EFFORT.profile) is None
    assert kept.truth(changed, EFFORT.samples) is None
    assert kept.frame(small_shot(), replace(HARD, resolution=64), EFFORT.repeats, EFFORT.profile) is None
    assert kept.truth(small_shot(), EFFORT.samples + 1) is None


def test_damaged_files_are_measured_again_and_strangers_forgotten(tmp_path: Path) -> None:
    run(MeasurementCache(tmp_path), Picture(small_shot(), [HARD]))
    for path in tmp_path.glob("*.npz"):
        path.write_bytes(path.read_bytes()[:100])
    (tmp_path / "uniform-of-yesterday.npz").write_bytes(b"")
    kept = MeasurementCache(tmp_path)
    _, said = run(kept, Picture(small_shot(), [HARD]))
    assert any("hard" in doing for doing in said)
    kept.forget_others()
    assert len(list(tmp_path.glob("*.npz"))) == 2, "a truth and a technique"
    assert kept.frame(small_shot(), HARD, EFFORT.repeats, EFFORT.profile) is not None


def test_digests_tell_content_apart() -> None:
    first = [np.zeros(3, np.float32), np.zeros(3, np.int32), np.zeros((3, 1), np.float32), (1, 2), [1, 2], (12,), "12"]
    names = [digest(value) for value in first]
    assert len(set(names)) == len(first)
    assert digest([np.arange(4), {"not": "a dataclass"}]) == digest([np.arange(4), {"not": "a dataclass"}])


def test_a_required_technique_that_cannot_do_a_light_is_refused_before_anything_is_measured(tmp_path: Path) -> None:
    shot = with_light(small_shot(), LINE)
    with pytest.raises(OptionError, match="penumbra_wedges"):
        run(
            MeasurementCache(tmp_path / "cache"),
            Picture(shot, [HARD, make_technique("penumbra_wedges")], required=True),
        )
    assert not (tmp_path / "cache").exists()


def test_lights_are_measured_one_by_one_and_techniques_that_cannot_do_all_are_named(tmp_path: Path) -> None:
    shot = small_shot()
    (light,) = shot.scene.lights
    shot.scene.lights = [light, LINE]
    (measured,), _ = run(MeasurementCache(tmp_path), Picture(shot, [UNIFORM, make_technique("penumbra_wedges")]))
    (uniform,) = measured.results
    assert len(uniform.comparisons) == 2
    assert uniform.comparisons[0] != uniform.comparisons[1]
    (sentence,) = measured.skipped
    assert "penumbra_wedges" in sentence
    assert shot.scene.lights[0] is light, "lights that moved for the timing are back"


def test_a_light_without_a_place_is_measured(tmp_path: Path) -> None:
    """Its frames are redrawn as others' are, by a light that turns instead of moving."""
    sun = DirectionalLight(direction=(0.3, -1.0, 0.2), irradiance=(3.0, 3.0, 3.0))
    (measured,), _ = run(MeasurementCache(tmp_path), Picture(open_shot("blocker", lights=[sun], size=(32, 24)), [HARD]))
    assert [result.label for result in measured.results] == ["hard"]


def test_techniques_that_refuse_a_picture_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One of two refuses: the report goes on without it. Both refuse: there is no report."""
    rendered = comparison._rendered

    def refusing(shot: Shot, technique: Technique, *rest):
        if technique == UNIFORM:
            raise DeviceError("too little memory")
        return rendered(shot, technique, *rest)

    monkeypatch.setattr(comparison, "_rendered", refusing)
    (measured,), _ = run(MeasurementCache(tmp_path), Picture(small_shot(), [UNIFORM, HARD]))
    assert [result.label for result in measured.results] == ["hard"]
    assert measured.skipped == ["uniform:grid=3: too little memory"]
    with pytest.raises(DeviceError, match="too little memory"):
        run(MeasurementCache(tmp_path), Picture(small_shot(), [UNIFORM]))


def test_the_schedule_tells_shares_of_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fast and a slow kind, twice: after the first picture the share is that of the time."""
    clock = [0.0]
    monkeypatch.setattr("softshadows.compare.schedule.time.perf_counter", lambda: clock[0])
    told: list[float] = []
    schedule = Schedule(lambda doing, share: told.append(share))
    for kind in ("fast", "slow") * 2:
        schedule.expect(kind)
    for kind, seconds in (("fast", 1.0), ("slow", 9.0)):
        with schedule.step(kind, kind):
            clock[0] += seconds
    with schedule.step("fast", "fast") as within:
        assert told[-1] == pytest.approx(10 / 20)
        clock[0] += 0.5
        within("half of it", 0.5)
        assert told[-1] == pytest.approx(10.5 / 20)
        clock[0] += 0.5
    with schedule.step("slow", "slow"):
        assert told[-1] == pytest.approx(11 / 20)


def test_time_left_in_words() -> None:
    assert time_left(5.0, 0.0) == ""
    assert time_left(10.0, 0.5) == "10 s left"
    assert time_left(60.0, 0.1) == "9 min left"
    assert time_left(3600.0, 0.25) == "3.0 h left"


def test_the_command_measures_views_and_option_sets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two scenes by two cameras; one technique with two sets of options; a second run measures nothing."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.toml").write_text('scene = "blocker"\nsize = [32, 24]\n')
    cameras = ["--camera", "position=2,3,4:target=0,0,0", "--camera", "position=0,5,1:target=0,0,0"]
    arguments = ["compare", "shot.toml", "shot.toml", *cameras, "-t", "hard,uniform:grid=2,uniform:grid=3"]
    arguments += ["--samples", "4", "--repeats", "1", "-o", "out"]
    compared = CliRunner().invoke(app, arguments)
    assert compared.exit_code == 0, compared.output
    data = read_results(Path("out/results.json"))
    assert [picture["scene"] for picture in data["pictures"]] == [
        "shot, view 1",
        "shot, view 2",
        "shot, view 1 (2)",
        "shot, view 2 (2)",
    ]
    for picture in data["pictures"]:
        assert [one["label"] for one in picture["techniques"]] == ["hard", "uniform:grid=2", "uniform:grid=3"]
        assert set(picture["techniques"][0]["times"]) == {"frame", "cached"}
    assert data["pictures"][0]["camera"] != data["pictures"][1]["camera"]
    assert len(list(Path("out/cache").glob("*.npz"))) == 2 * 4, "equal pictures are measured once"
    assert CliRunner().invoke(app, arguments).exit_code == 0
    again = read_results(Path("out/results.json"))
    assert json.dumps(again["pictures"]) == json.dumps(data["pictures"])
