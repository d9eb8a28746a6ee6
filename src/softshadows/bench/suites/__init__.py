"""Benchmark suites, by name. Adding one: a module with `run`, and its line in this list."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from softshadows.bench.suites import adaptive, baselines, bitmask, choice, linear, mobile, rays, scaling, wedges
from softshadows.compare.measure import Measurement, Notice
from softshadows.errors import OptionError


@dataclass(frozen=True)
class Settings:
    """What a run may change: picture size (None: the suite's own), truth samples, timed frames per technique.

    `folder` is where a suite that makes pictures writes them; None for nowhere.
    """

    size: tuple[int, int] | None = None
    samples: int = 256
    repeats: int = 5
    folder: Path | None = None


SUITES: dict[str, Callable[[Settings, Notice], list[Measurement]]] = {
    "adaptive": adaptive.run,
    "baselines": baselines.run,
    "bitmask": bitmask.run,
    "choice": choice.run,
    "linear": linear.run,
    "mobile": mobile.run,
    "rays": rays.run,
    "scaling": scaling.run,
    "wedges": wedges.run,
}


def find_suite(name: str) -> Callable[[Settings, Notice], list[Measurement]]:
    """The suite called `name`; OptionError with those there are for any other."""
    if name not in SUITES:
        raise OptionError(f"there is no suite {name!r}; choose one of {', '.join(SUITES)}")
    return SUITES[name]


def describe(name: str) -> str:
    """The first line of a suite's docstring."""
    return (SUITES[name].__doc__ or "").strip().splitlines()[0]
