"""Charts as SVG files that documents show as images: marks or lines over two logarithmic axes.

The same numbers give the same text. Colours serve on light and on dark pages alike, since an image does not know which
it lies on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

from softshadows.compare.page.plot import HEIGHT, WIDTH, Axis, grid, logarithmic_axis

LEFT, RIGHT, TOP, BOTTOM = 68, 20, 16, 46
"""Margins around the axes."""
CHARACTER, LINE, KEY = 7.0, 18.0, 22.0
"""About the width of a letter, the height of a line of the legend, and what its mark takes."""
COLOURS = (
    "#4477aa",
    "#ee6677",
    "#228833",
    "#ccbb44",
    "#66ccee",
    "#aa3377",
    "#999999",
    "#dd8833",
    "#44aa99",
    "#7766cc",
    "#885522",
    "#222288",
)
"""Paul Tol's bright scheme, which colour-blind readers can tell apart, and five more."""
STYLE = (
    "text{font:12px system-ui,sans-serif;fill:#888}line{stroke:#8886;stroke-width:1}polyline{fill:none;stroke-width:2}"
)


class Mark(NamedTuple):
    """A point of a series; `says` is its tooltip."""

    x: float
    y: float
    says: str


Series = Mapping[str, Sequence[Mark]]
"""Marks by the name of the series, in the order of the legend."""


def chart(series: Series, across: str, up: str, *, joined: bool) -> str:
    """An SVG of all marks, with what the axes mean; those of a series `joined` by a line, or not."""
    marks = [mark for points in series.values() for mark in points]
    legend_rows = _legend_rows(list(series))
    height = HEIGHT + LINE * len(legend_rows)
    x_axis = logarithmic_axis([mark.x for mark in marks], LEFT, WIDTH - RIGHT)
    y_axis = logarithmic_axis([mark.y for mark in marks], HEIGHT - BOTTOM, TOP)
    colours = {name: COLOURS[index % len(COLOURS)] for index, name in enumerate(series)}
    drawn = [_series(points, colours[name], x_axis, y_axis, joined) for name, points in series.items()]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" width="{WIDTH}" '
        f'height="{height:g}"><style>{STYLE}</style>\n{grid(x_axis, y_axis, across, up)}\n'
        + "\n".join(drawn)
        + f"\n{_legend(legend_rows, colours)}\n</svg>\n"
    )


def _series(points: Sequence[Mark], colour: str, x_axis: Axis, y_axis: Axis, joined: bool) -> str:
    places = [(x_axis.at(mark.x), y_axis.at(mark.y)) for mark in points]
    line = ""
    if joined:
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        line = f'<polyline stroke="{colour}" points="{corners}"/>'
    return line + "".join(
        f'<circle fill="{colour}" cx="{x:.1f}" cy="{y:.1f}" r="4.5"><title>{escape(mark.says)}</title></circle>'
        for mark, (x, y) in zip(points, places, strict=True)
    )


def _legend_rows(names: Sequence[str]) -> list[list[tuple[float, str]]]:
    """The names in rows that fit the width, each with its left end."""
    rows: list[list[tuple[float, str]]] = [[]]
    x = float(LEFT)
    for name in names:
        extent = KEY + CHARACTER * len(name) + KEY
        if rows[-1] and x + extent > WIDTH:
            rows.append([])
            x = float(LEFT)
        rows[-1].append((x, name))
        x += extent
    return rows


def _legend(rows: Sequence[Sequence[tuple[float, str]]], colours: Mapping[str, str]) -> str:
    parts = []
    for index, row in enumerate(rows):
        y = HEIGHT + LINE * index + LINE / 2
        for x, name in row:
            parts.append(f'<circle fill="{colours[name]}" cx="{x + 6:g}" cy="{y:g}" r="4.5"/>')
            parts.append(f'<text x="{x + KEY - 6:g}" y="{y + 4:g}">{escape(name)}</text>')
    return "".join(parts)
