"""results.json: whole files are read, and those that are not are refused by place."""

from __future__ import annotations

import copy
import dataclasses
import json
from pathlib import Path

import pytest

from softshadows.compare.results import SCHEMA
from softshadows.compare.schema import RESULTS, check, read_results
from softshadows.errors import OptionError
from softshadows.metrics import Comparison

TIMING = {"median_ms": 2.0, "fastest_ms": 1.0, "slowest_ms": 3, "frames": 5}
COMPARISON = {field.name: 0.01 for field in dataclasses.fields(Comparison)}
TECHNIQUE = {
    "label": "hard",
    "name": "hard",
    "options": {},
    "shadow_maps": 1,
    "lookups_per_pixel": 1.0,
    "frame_ms": 2.0,
    "times": {"frame": TIMING},
    "gpu_ms": {"maps": 1.0},
    "cpu_ms": 1.0,
    "gpu_bytes": 1000,
    "flip": None,
    "warnings": [],
    "figures": {},
    "lights": [COMPARISON],
}
PICTURE = {
    "scene": "blocker",
    "size": [64, 48],
    "triangles": 4,
    "camera": {"position": [0, 1, 2], "target": [0, 0, 0], "vertical_fov": 45.0, "up": None},
    "lights": [{"type": "rect"}],
    "truth": {"samples": 64, "standard_error": 0.001, "seconds": 0.5},
    "techniques": [TECHNIQUE],
    "skipped": [],
    "figures": {},
}
ENVIRONMENT = {
    "adapter": {"adapter": "a", "backend": "Vulkan", "driver": "d", "features": [], "limits": {}},
    "cpu": "c",
    "cpu_count": 2,
    "system": "s",
    "versions": {"python": "3", "embreex": None},
    "commit": None,
}


def made_up() -> dict:
    """A whole file with one technique on one picture."""
    data = {"schema": SCHEMA, "created": "now", "environment": ENVIRONMENT, "suite": "mine", "pictures": [PICTURE]}
    return copy.deepcopy(data)


def test_a_whole_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(json.dumps({**made_up(), "more": 1}))
    assert read_results(path)["more"] == 1


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (["pictures", 0, "techniques", 0, "times", "frame", "frames"], "5", "pictures[0].techniques[0].times.frame"),
        (["pictures", 0, "techniques", 0, "lights", 0, "rmse"], None, "rmse must be float"),
        (["pictures", 0, "size"], [64, 4.5], "pictures[0].size[1]"),
        (["pictures", 0, "triangles"], True, "triangles must be int"),
        (["environment", "adapter"], {}, "environment.adapter has no 'adapter'"),
        (["pictures"], None, "pictures must be list"),
    ],
)
def test_other_shapes_are_refused_by_place(place: list, value: object, says: str) -> None:
    data = made_up()
    inner = data
    for name in place[:-1]:
        inner = inner[name]
    inner[place[-1]] = value
    with pytest.raises(ValueError) as raised:  # noqa: PT011
        check(data, RESULTS)
    assert says in str(raised.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "is no JSON"),
        ("[]", "its schema is None"),
        ('{"schema": "softshadows-results/0"}', "results/0"),
        (None, "cannot be read"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str | None, says: str) -> None:
    path = tmp_path / "results.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(OptionError, match=says):
        read_results(path)


def test_a_file_that_lacks_something_is_refused(tmp_path: Path) -> None:
    data = made_up()
    del data["environment"]
    path = tmp_path / "results.json"
    path.write_text(json.dumps(data))
    with pytest.raises(OptionError, match="the file has no 'environment'"):
        read_results(path)
