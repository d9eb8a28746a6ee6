"""What got worse from one results.json to another, beyond noise: `softshadows bench compare`.

Pictures are matched by name and size, techniques by label. What noise is:

times     wall times of frames interleaved have a spread, from the fastest to the slowest. A technique got slower where
          each median lies outside the other's spread and the medians are more than SLIGHT_TIME apart: even of two runs
          of the same code on an idle machine, spreads sometimes do not touch. Times are compared only on the same
          adapter, driver and processor, and where both have MIN_FRAMES frames.
errors    are no matter of chance: the same code on the same adapter gives the same figures, since the truth has a
          seed. An error got worse where it grew by more than SLIGHT_ERROR of itself and by more than what other
          roundings move, ERRORS[figure]. They are compared where camera, lights, triangles and rays are the same.
costs     bytes on the GPU and look-ups per pixel: more than SLIGHT_COST.

A technique that was measured and is missing from a picture that both have counts as worse.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from softshadows.errors import OptionError

SLIGHT_TIME, SLIGHT_ERROR, SLIGHT_COST = 0.05, 0.02, 0.01
"""Shares of the value before."""
MIN_FRAMES = 3
"""The fewest that have a median and a spread."""
ERRORS: dict[str, float] = {
    "rmse": 1e-4,
    "penumbra_rmse": 1e-4,
    "bias": 1e-4,
    "p99": 1e-3,
    "leak_rate": 1e-4,
    "false_shadow_rate": 1e-4,
    "penumbra_width_error": 1e-2,
}
"""Figures of a metrics.Comparison and what they may move by rounding; signed ones count by their size."""
FLIP = 1e-3
COSTS = ("gpu_bytes", "lookups_per_pixel")
SUBJECT = ("triangles", "camera", "lights")
"""What of a picture must be equal for its figures to be comparable."""


@dataclass(frozen=True)
class Change:
    """A figure of one technique on one picture that moved beyond noise; `share` of the value before, None from 0."""

    picture: str
    technique: str
    figure: str
    before: float
    after: float

    @property
    def share(self) -> float | None:
        return self.after / self.before - 1.0 if self.before else None


@dataclass
class Changes:
    """What moved, by direction; techniques that are gone; what could not be compared, in sentences; how much was.

    `without_spread` counts times of too few frames.
    """

    worse: list[Change] = field(default_factory=list)
    better: list[Change] = field(default_factory=list)
    gone: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    compared: int = 0
    without_spread: int = 0

    @property
    def got_worse(self) -> bool:
        return bool(self.worse or self.gone)

    def add(self, change: Change, slack: float) -> None:
        """Note a change that is larger than `slack`, in whichever direction."""
        self.compared += 1
        if abs(change.after - change.before) > slack:
            (self.worse if change.after > change.before else self.better).append(change)


def changes(before: dict[str, Any], after: dict[str, Any]) -> Changes:
    """All changes between two results.json; OptionError where they have no picture in common."""
    found = Changes()
    earlier, later = (_by_name(data) for data in (before, after))
    common = [name for name in earlier if name in later]
    if not common:
        raise OptionError(
            f"nothing to compare: the first file has {', '.join(earlier) or 'no pictures'}, "
            f"the second {', '.join(later) or 'none'}"
        )
    found.notes += [f"{name} is only in the first file" for name in earlier if name not in later]
    found.notes += [f"{name} is only in the second file" for name in later if name not in earlier]
    same_machine = _machine(before) == _machine(after)
    if not same_machine:
        found.notes.append(f"times are not compared: {_machine(before)} before, {_machine(after)} after")
    for name in common:
        _compare_pictures(found, name, earlier[name], later[name], same_machine)
    if found.without_spread:
        found.notes.append(
            f"{found.without_spread} times of fewer than {MIN_FRAMES} frames have no spread, not compared"
        )
    return found


def _by_name(data: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Pictures by name and size."""
    return {"{} {}×{}".format(picture["scene"], *picture["size"]): picture for picture in data["pictures"]}


def _machine(data: dict[str, Any]) -> str:
    environment = data["environment"]
    adapter = environment["adapter"]
    return f"{adapter['adapter']} ({adapter['driver']}), {environment['cpu_count']} × {environment['cpu']}"


def _compare_pictures(
    found: Changes, name: str, before: dict[str, Any], after: dict[str, Any], same_machine: bool
) -> None:
    different = [part for part in SUBJECT if before[part] != after[part]]
    if different:
        found.notes.append(f"{name} is not compared: its {', '.join(different)} differ")
        return
    same_rays = before["truth"]["samples"] == after["truth"]["samples"]
    if not same_rays:
        found.notes.append(f"{name}: errors are not compared, since the numbers of rays differ")
    later = {technique["label"]: technique for technique in after["techniques"]}
    for technique in before["techniques"]:
        label = technique["label"]
        if label not in later:
            found.gone.append(f"{name}: {label} is gone" + "".join(f" ({why})" for why in _reasons(after, label)))
            continue
        pairs = [*_costs(technique, later[label])]
        if same_machine:
            pairs += _times(technique, later[label], found)
        if same_rays:
            pairs += _errors(technique, later[label])
        for figure, was, now, slack in pairs:
            found.add(Change(name, label, figure, was, now), slack)


def _reasons(picture: dict[str, Any], label: str) -> Iterator[str]:
    yield from (sentence for sentence in picture["skipped"] if sentence.startswith(f"{label}:"))


Pair = tuple[str, float, float, float]
"""A figure, its values before and after, and by how much it may differ."""


def _times(before: dict[str, Any], after: dict[str, Any], found: Changes) -> Iterator[Pair]:
    """The medians, with infinite slack where one lies in the other's spread."""
    for name, was in before["times"].items():
        now = after["times"].get(name)
        if now is None:
            continue
        if min(was["frames"], now["frames"]) < MIN_FRAMES:
            found.without_spread += 1
            continue
        apart = not _within(now["median_ms"], was) and not _within(was["median_ms"], now)
        slack = SLIGHT_TIME * was["median_ms"] if apart else float("inf")
        yield f"{name} ms", was["median_ms"], now["median_ms"], slack


def _within(milliseconds: float, timing: dict[str, float]) -> bool:
    return timing["fastest_ms"] <= milliseconds <= timing["slowest_ms"]


def _costs(before: dict[str, Any], after: dict[str, Any]) -> Iterator[Pair]:
    for name in COSTS:
        yield name, before[name], after[name], SLIGHT_COST * before[name]


def _errors(before: dict[str, Any], after: dict[str, Any]) -> Iterator[Pair]:
    lights = zip(before["lights"], after["lights"], strict=True)
    for index, (was, now) in enumerate(lights):
        of = f" of light {index}" if len(before["lights"]) > 1 else ""
        for name, rounding in ERRORS.items():
            size, size_now = abs(was[name]), abs(now[name])
            yield f"{name}{of}", size, size_now, max(rounding, SLIGHT_ERROR * size)
    if before["flip"] is not None and after["flip"] is not None:
        yield "FLIP", before["flip"], after["flip"], max(FLIP, SLIGHT_ERROR * before["flip"])
