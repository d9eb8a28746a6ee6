"""bench compare: what counts as worse, beyond noise, on made-up results."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest
from test_schema import PICTURE, made_up
from typer.testing import CliRunner

from softshadows.bench.changes import Changes, changes
from softshadows.cli.app import app
from softshadows.errors import OptionError


def with_technique(**figures: object) -> dict:
    """The made-up file with other figures of its technique."""
    data = made_up()
    data["pictures"][0]["techniques"][0].update(figures)
    return data


def with_times(fastest: float, median: float, slowest: float, frames: int = 5) -> dict:
    timing = {"median_ms": median, "fastest_ms": fastest, "slowest_ms": slowest, "frames": frames}
    return with_technique(times={"frame": timing}, frame_ms=median)


def with_errors(**errors: float) -> dict:
    data = made_up()
    data["pictures"][0]["techniques"][0]["lights"][0].update(errors)
    return data


def figures(found: Changes) -> tuple[list[str], list[str]]:
    return [change.figure for change in found.worse], [change.figure for change in found.better]


def test_the_same_twice_is_no_change() -> None:
    found = changes(made_up(), made_up())
    assert figures(found) == ([], [])
    assert not found.got_worse
    assert found.notes == []
    assert found.compared == 1 + 2 + 7


BEFORE = (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("after", "worse", "better"),
    [
        ((3.1, 4.0, 5.0), True, False),  # apart
        ((1.9, 4.0, 5.0), False, False),  # the median before lies in the later spread
        ((2.5, 2.9, 5.0), False, False),  # the median after lies in the earlier spread
        ((0.2, 0.5, 0.9), False, True),
        ((0.2, 0.5, 2.1), False, False),
    ],
)
def test_times_change_where_each_median_lies_outside_the_other_spread(after: tuple, worse: bool, better: bool) -> None:
    found = changes(with_times(*BEFORE), with_times(*after))
    assert figures(found) == (["frame ms"] * worse, ["frame ms"] * better)
    assert found.got_worse == worse


def test_times_that_hardly_differ_are_noise_however_narrow_their_spreads() -> None:
    assert not changes(with_times(99, 100, 101), with_times(103, 104, 105)).got_worse
    (change,) = changes(with_times(99, 100, 101), with_times(105, 106, 107)).worse
    assert change.share == pytest.approx(0.06)


def test_few_frames_have_no_spread() -> None:
    found = changes(with_times(2, 2, 2, frames=1), with_times(9, 9, 9))
    assert not found.got_worse
    assert "fewer than 3" in found.notes[0]


@pytest.mark.parametrize(("place", "value"), [("cpu", "another"), ("cpu_count", 64)])
def test_times_of_other_machines_are_not_compared(place: str, value: object) -> None:
    after = with_times(10, 20, 30)
    after["environment"][place] = value
    found = changes(with_times(*BEFORE), after)
    assert not found.got_worse
    assert "times are not compared" in found.notes[0]
    after["pictures"][0]["techniques"][0]["lights"][0]["rmse"] = 0.5
    assert figures(changes(with_times(*BEFORE), after)) == (["rmse"], [])


@pytest.mark.parametrize(
    ("before", "after", "worse", "better"),
    [
        ({"rmse": 0.02}, {"rmse": 0.0203}, [], []),  # 1.5 %
        ({"rmse": 0.02}, {"rmse": 0.0206}, ["rmse"], []),
        ({"rmse": 0.02}, {"rmse": 0.01}, [], ["rmse"]),
        ({"leak_rate": 0.0}, {"leak_rate": 5e-5}, [], []),
        ({"leak_rate": 0.0}, {"leak_rate": 5e-4}, ["leak_rate"], []),
        ({"bias": -0.02}, {"bias": 0.02}, [], []),  # as far off to the other side
        ({"bias": -0.02}, {"bias": -0.03}, ["bias"], []),
        ({"penumbra_width_error": -0.5}, {"penumbra_width_error": 0.2}, [], ["penumbra_width_error"]),
    ],
)
def test_errors(before: dict, after: dict, worse: list, better: list) -> None:
    assert figures(changes(with_errors(**before), with_errors(**after))) == (worse, better)


def test_costs() -> None:
    found = changes(
        with_technique(gpu_bytes=1000, lookups_per_pixel=9.0), with_technique(gpu_bytes=1020, lookups_per_pixel=4.0)
    )
    assert figures(found) == (["gpu_bytes"], ["lookups_per_pixel"])
    assert not changes(with_technique(gpu_bytes=1000), with_technique(gpu_bytes=1009)).got_worse


def test_a_technique_that_is_gone_is_worse() -> None:
    after = made_up()
    after["pictures"][0]["techniques"] = []
    after["pictures"][0]["skipped"] = ["hard: too little memory", "pcf: no"]
    found = changes(made_up(), after)
    assert found.got_worse
    assert found.gone == ["blocker 64×48: hard is gone (hard: too little memory)"]


def test_pictures_of_other_things_are_not_compared() -> None:
    after = with_errors(rmse=0.9)
    after["pictures"][0]["camera"]["vertical_fov"] = 46.0
    found = changes(made_up(), after)
    assert (found.compared, found.got_worse) == (0, False)
    assert "camera" in found.notes[0]
    after = with_errors(rmse=0.9)
    after["pictures"][0]["truth"]["samples"] = 4
    found = changes(made_up(), after)
    assert not found.got_worse
    assert "rays" in found.notes[0]


def test_pictures_that_one_file_lacks_are_named() -> None:
    after = made_up()
    after["pictures"].append(copy.deepcopy({**PICTURE, "scene": "new"}))
    assert changes(made_up(), after).notes == ["new 64×48 is only in the second file"]
    after["pictures"] = after["pictures"][1:]
    with pytest.raises(OptionError, match="nothing to compare"):
        changes(made_up(), after)


@pytest.mark.parametrize(("rmse", "code", "says"), [(0.01, 0, "nothing got worse"), (0.5, 1, "rmse")])
def test_the_command(tmp_path: Path, rmse: float, code: int, says: str) -> None:
    paths = [tmp_path / "a.json", tmp_path / "b.json"]
    for path, data in zip(paths, (made_up(), with_errors(rmse=rmse)), strict=True):
        path.write_text(json.dumps(data))
    result = CliRunner().invoke(app, ["bench", "compare", *map(str, paths)], env={"COLUMNS": "120"})
    assert result.exit_code == code, result.output
    assert says in result.output
