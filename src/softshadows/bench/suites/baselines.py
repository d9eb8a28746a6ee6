"""The standard techniques on every built-in scene, and on the real scenes where they are at hand."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from softshadows.compare.measure import Measurement, Notice, measure, measure_each
from softshadows.errors import SceneError
from softshadows.scene.builtin import SCENES
from softshadows.scene.shot import open_shot
from softshadows.techniques import TECHNIQUES, make_technique

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

NAMES = ("none", "hard", "pcf", "pcss", "vsm", "uniform")
SIZE = (512, 384)
"""Size of suites that ask for no other."""
SMALL = (320, 240)
"""Size of this suite, which has many pictures: so they take minutes on two cores without a GPU."""
SCENES_VARIABLE = "SOFTSHADOWS_SCENES"


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """The standard techniques on the built-in scenes, and on the shots in $SOFTSHADOWS_SCENES where it is set."""
    techniques = [make_technique(name) for name in NAMES if name in TECHNIQUES]

    def measure_source(source: str, within: Notice) -> Measurement:
        shot = replace(open_shot(source), size=settings.size or SMALL)
        return measure(shot, techniques, samples=settings.samples, repeats=settings.repeats, notice=within, skip=True)

    return measure_each(sources(), lambda source: Path(source).stem, measure_source, notice)


def sources() -> Iterator[str]:
    """Names of built-in scenes, then paths of shots; SceneError where the variable is set to a folder without any."""
    yield from SCENES
    folder = os.environ.get(SCENES_VARIABLE)
    if folder:
        shots = sorted(Path(folder, "shots").glob("*.toml"))
        if not shots:
            raise SceneError(f"{SCENES_VARIABLE} is set, but holds no shots/*.toml", code="SCENE_UNKNOWN", file=folder)
        yield from map(str, shots)


def real_shots(names: Sequence[str]) -> list[Path]:
    """The files of those shots that $SOFTSHADOWS_SCENES holds, none where it is not set; SceneError where it holds none
    of them."""
    folder = os.environ.get(SCENES_VARIABLE)
    if not folder:
        return []
    found = [file for name in names if (file := Path(folder, "shots", f"{name}.toml")).exists()]
    if not found:
        raise SceneError(
            f"{SCENES_VARIABLE} is set, but holds none of shots/{{{','.join(names)}}}.toml",
            code="SCENE_UNKNOWN",
            file=folder,
        )
    return found
