"""Error against time as SVG, both on logarithmic axes, with the Pareto front: techniques that none beats in both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from softshadows.compare.measure import Measurement
from softshadows.metrics import Comparison

WIDTH, HEIGHT = 760, 400
LEFT, RIGHT, TOP, BOTTOM = 64, 24, 16, 48
"""The margins around the axes, in the plot's units."""
CHARACTER, LINE = 7.0, 15.0
"""About the extent of a letter of the labels."""
LEAST = 1e-6
"""Errors and times below it are drawn there: a logarithm needs a positive number."""


class Point(NamedTuple):
    label: str
    ms: float
    error: float


class Axis(NamedTuple):
    """From the logarithms `low`..`high` to the positions `start`..`end`."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        share = (math.log10(max(value, LEAST)) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """1, 2 and 5 times powers of ten within the axis; only powers where there would be more than nine."""
        powers = range(math.floor(self.low) - 1, math.ceil(self.high) + 1)
        all_of = [m * 10.0**p for p in powers for m in (1, 2, 5)]
        within = [v for v in all_of if self.low - 1e-9 <= math.log10(v) <= self.high + 1e-9]
        return within if len(within) <= 9 else [v for v in within if math.log10(v) % 1 in (0.0, 1.0)]


def points_of(measurement: Measurement) -> list[Point]:
    """Each technique's median time of a frame and its rmse, over all lights' pixels."""

    def rmse(lights: Sequence[Comparison]) -> float:
        pixels = sum(light.pixels for light in lights)
        return math.sqrt(sum(light.pixels * light.rmse**2 for light in lights) / max(pixels, 1))

    return [Point(result.label, result.frame_ms, rmse(result.comparisons)) for result in measurement.results]


def pareto_front(points: Sequence[Point]) -> list[Point]:
    """Those to which no other is better in one and at least as good in the other, from fast to exact."""
    front: list[Point] = []
    for point in sorted(points, key=lambda p: (p.ms, p.error)):
        if not front or point.error < front[-1].error:
            front.append(point)
    return front


def plot(measurement: Measurement) -> str:
    """A figure with the plot; empty where there is nothing to plot."""
    points = points_of(measurement)
    if not points:
        return ""
    across = logarithmic_axis([p.ms for p in points], LEFT, WIDTH - RIGHT)
    up = logarithmic_axis([p.error for p in points], HEIGHT - BOTTOM, TOP)
    front = pareto_front(points)
    line = " ".join(f"{across.at(p.ms):.1f},{up.at(p.error):.1f}" for p in front)
    says = (
        f"Error against time of {measurement.shot.name}. On the Pareto front, where no other is both faster and closer "
        f"to the truth: {', '.join(p.label for p in front)}."
    )
    return (
        f'<figure class="plot"><svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(says)}">'
        f'<g class="grid">{grid(across, up, "ms per frame", "rmse")}</g>'
        f'<polyline class="front" points="{line}"/>{_marks(points, front, across, up)}</svg>'
        f"<figcaption>{escape(says)} Filled points and the line mark it; lower left is better. "
        "The error is the rmse of visibility over all lights.</figcaption></figure>"
    )


def logarithmic_axis(values: Sequence[float], start: float, end: float) -> Axis:
    """Some room beyond the values, and at least half a decade."""
    logarithms = [math.log10(max(value, LEAST)) for value in values]
    low, high = min(logarithms), max(logarithms)
    room = max(0.08 * (high - low), (0.5 - (high - low)) / 2, 0.05)
    return Axis(low - room, high + room, start, end)


def grid(across: Axis, up: Axis, across_says: str, up_says: str) -> str:
    """Lines and numbers at both axes' ticks, and what the axes mean, as SVG; `up` starts at the bottom."""
    parts = []
    for value in across.ticks():
        x = across.at(value)
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{up.end:g}" y2="{up.start:g}"/>')
        parts.append(f'<text x="{x:.1f}" y="{up.start + 18:g}" text-anchor="middle">{_number(value)}</text>')
    for value in up.ticks():
        y = up.at(value)
        parts.append(f'<line x1="{across.start:g}" x2="{across.end:g}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{across.start - 8:g}" y="{y + 4:.1f}" text-anchor="end">{_number(value)}</text>')
    centre, middle = (across.start + across.end) / 2, (up.start + up.end) / 2
    parts.append(f'<text x="{centre:g}" y="{HEIGHT - 8}" text-anchor="middle">{escape(across_says)}</text>')
    parts.append(
        f'<text transform="translate(14 {middle:g}) rotate(-90)" text-anchor="middle">{escape(up_says)}</text>'
    )
    return "".join(parts)


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:g}"


def _marks(points: Sequence[Point], front: Sequence[Point], across: Axis, up: Axis) -> str:
    """Points with their labels, each label where it covers no point and no label that is already there."""
    places = [(across.at(p.ms), up.at(p.error)) for p in points]
    taken = [(x - 5, y - 5, x + 5, y + 5) for x, y in places]
    parts = []
    for point, (x, y) in zip(points, places, strict=True):
        box = _free_box(x, y, CHARACTER * len(point.label), taken)
        taken.append(box)
        kind = "best" if point in front else "other"
        says = escape(f"{point.label}: {point.ms:.1f} ms, rmse {point.error:.4f}")
        parts.append(f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="5"><title>{says}</title></circle>')
        parts.append(f'<text x="{box[0]:.1f}" y="{box[3] - 4:.1f}">{escape(point.label)}</text>')
    return "".join(parts)


def _free_box(x: float, y: float, width: float, taken: Sequence[tuple[float, float, float, float]]) -> tuple:
    """(left, top, right, bottom) of a label beside (x, y): right, left, above, below, and farther up and down."""
    boxes = []
    for lift in (0.0, -LINE, LINE, -2 * LINE, 2 * LINE):
        for left in (x + 9, x - 9 - width, x - width / 2):
            top = y - LINE / 2 + lift
            boxes.append((left, top, left + width, top + LINE))
    inside = [
        (left, top, right, bottom)
        for left, top, right, bottom in boxes
        if left >= LEFT and right <= WIDTH and top >= 0.0 and bottom <= HEIGHT - BOTTOM
    ]
    free = [box for box in inside if not any(_overlap(box, other) for other in taken)]
    return (free or inside or boxes)[0]


def _overlap(one: tuple, other: tuple) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
