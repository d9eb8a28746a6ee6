"""Every technique on the same frames: the table by which the documentation says which one to use.

Views: `figures`, `sphere_cube`, `room` and `fence` under their rectangle lights; `figures` and `fence` under a line as
long as their light is wide ("figures, line light"). All techniques that can do the light, with their defaults, and
those of `BESIDE` with the options that serve best where their manuals advise others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from softshadows.bench.suites.baselines import SIZE
from softshadows.bench.suites.linear import under_a_line
from softshadows.compare.choice import can_do, techniques_from
from softshadows.compare.measure import Measurement, Notice, measure, measure_each
from softshadows.scene import builtin
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Adaptive, PenumbraWedges, Technique, VariablePenumbra

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

RECTANGLE = ("figures", "sphere_cube", "room", "fence")
LINE = ("figures", "fence")
BESIDE: tuple[Technique, ...] = (
    Adaptive(filter="cell", max_depth=2),
    Adaptive(visibility="ray"),
    Adaptive(visibility="hybrid"),
    VariablePenumbra(kernels="from_light"),
    PenumbraWedges(blending="union"),
)


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Every technique under rectangle and line lights, with errors and times to choose by."""

    def measure_view(view: Shot, within: Notice) -> Measurement:
        shot = replace(view, size=settings.size or SIZE)
        return measure(shot, techniques_for(shot), samples=settings.samples, repeats=settings.repeats, notice=within)

    return measure_each(views(), lambda view: view.name, measure_view, notice)


def views() -> Iterator[Shot]:
    """The views, rectangle lights first."""
    for name in RECTANGLE:
        yield open_shot(name)
    for name in LINE:
        yield under_a_line(f"{name}, line light", builtin.make(name))


def techniques_for(shot: Shot) -> list[Technique]:
    """All techniques that can do the shot's lights."""
    return [*techniques_from(shot, None, []), *(one for one in BESIDE if can_do(one, shot))]
