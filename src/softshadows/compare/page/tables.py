"""The page's tables: a row per technique and light, and what the columns say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from softshadows.compare.measure import Measurement, Result

MEBIBYTE = 2**20
TIME = "time"
"""The format of milliseconds: three or four figures, whatever the adapter."""


@dataclass(frozen=True)
class Column:
    """A figure: its heading, its format, what it means, and where it comes from (a result and a light's index).

    The least of a figure that `is_error` is set in bold.
    """

    heading: str
    form: str
    says: str
    value: Callable[[Result, int], float | None]
    is_error: bool = False


def _at_rest_ms(result: Result) -> float | None:
    return result.times["cached"].median_ms if "cached" in result.times else None


def _gpu_ms(result: Result) -> float | None:
    return sum(result.stats["gpu_ms"].values()) if result.stats["gpu_ms"] else None


def _error(name: str) -> Callable[[Result, int], float | None]:
    return lambda result, light: getattr(result.comparisons[light], name)


COLUMNS = (
    Column("shadow maps", "d", "maps drawn for the frame, all lights together", lambda r, _: r.stats["shadow_maps"]),
    Column("look-ups", ".1f", "shadow-map reads, on average per pixel", lambda r, _: r.stats["lookups_per_pixel"]),
    Column("ms", TIME, "median wall time of a frame and its read-back, all redrawn", lambda r, _: r.frame_ms),
    Column("ms at rest", TIME, "the same where nothing moved since the last frame", lambda r, _: _at_rest_ms(r)),
    Column("GPU ms", TIME, "time on the GPU of a frame redrawn, where the adapter tells", lambda r, _: _gpu_ms(r)),
    Column(
        "GPU MiB", ".0f", "held on the GPU, the scene's share included", lambda r, _: r.stats["gpu_bytes"] / MEBIBYTE
    ),
    Column("rmse", ".4f", "root mean square of visibility − truth", _error("rmse"), True),
    Column(
        "penumbra rmse",
        ".4f",
        "the same over pixels whose true visibility lies between 0.02 and 0.98",
        _error("penumbra_rmse"),
        True,
    ),
    Column("bias", "+.4f", "mean of visibility − truth: positive is too light", _error("bias"), True),
    Column("p99", ".3f", "99th percentile of the absolute error", _error("p99"), True),
    Column("leak rate", ".2%", "share of true umbra pixels with visibility above 0.1", _error("leak_rate"), True),
    Column(
        "false shadow",
        ".2%",
        "share of truly lit pixels with visibility below 0.9",
        _error("false_shadow_rate"),
        True,
    ),
    Column(
        "penumbra width",
        "+.1%",
        "relative error of the penumbra's width: positive is too wide",
        _error("penumbra_width_error"),
        True,
    ),
    Column(
        "FLIP", ".4f", "perceived difference of the pictures, all lights on: 0 alike to 1", lambda r, _: r.flip, True
    ),
)

OVERALL = ("rmse", "penumbra rmse", "bias", "leak rate", "false shadow", "penumbra width", "FLIP")
"""Columns whose mean over pictures and lights says something."""


def figures_table(measurement: Measurement) -> str:
    """A row per technique and light; the smallest error of each column in bold."""
    lights = range(len(measurement.shot.scene.lights))
    rows, names = [], []
    for light in lights:
        for result in measurement.results:
            names.append(result.label + (f", light {light}" if len(lights) > 1 else ""))
            rows.append([column.value(result, light) for column in COLUMNS])
    return _table(f"Figures of {measurement.shot.name}", COLUMNS, names, rows, len(measurement.results))


def overall_table(measurements: Sequence[Measurement]) -> str:
    """The mean over all pictures and lights of techniques that could do every picture; empty for one picture."""
    common = [
        first.label
        for first in measurements[0].results
        if all(any(r.label == first.label for r in measurement.results) for measurement in measurements)
    ]
    if len(measurements) < 2 or not common:
        return ""
    columns = [column for column in COLUMNS if column.heading in OVERALL]
    rows = [[_mean_over_all(measurements, label, column) for column in columns] for label in common]
    return "<h2>All pictures together</h2>" + _table(
        "Means over all pictures and their lights", columns, common, rows, len(common)
    )


def meanings() -> str:
    """What the columns say, as a list of definitions."""
    entries = "".join(f"<dt>{escape(column.heading)}</dt><dd>{escape(column.says)}</dd>" for column in COLUMNS)
    return f"<dl>{entries}</dl>"


def _mean_over_all(measurements: Sequence[Measurement], label: str, column: Column) -> float | None:
    values = [
        column.value(result, light)
        for measurement in measurements
        for result in measurement.results
        if result.label == label
        for light in range(len(result.comparisons))
    ]
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def _table(
    caption: str, columns: Sequence[Column], names: Sequence[str], rows: Sequence[Sequence[float | None]], group: int
) -> str:
    """The best are sought within `group` rows at a time: one light's."""
    head = "".join(f'<th scope="col" title="{escape(c.says)}">{escape(c.heading)}</th>' for c in columns)
    body = []
    for first in range(0, len(rows), max(group, 1)):
        some = rows[first : first + group]
        best = [min((abs(v) for v in column if v is not None), default=None) for column in zip(*some, strict=True)]
        for name, row in zip(names[first : first + group], some, strict=True):
            cells = "".join(map(_cell, columns, row, best))
            body.append(f'<tr><th scope="row">{escape(name)}</th>{cells}</tr>')
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}"><table>'
        f'<caption>{escape(caption)}</caption><thead><tr><th scope="col">technique</th>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
    )


def _cell(column: Column, value: float | None, best: float | None) -> str:
    if value is None:
        return "<td>–</td>"
    is_best = column.is_error and best is not None and abs(value) <= best
    return f"<td{' class=best' if is_best else ''}>{_written(value, column.form)}</td>"


def _written(value: float, form: str) -> str:
    if form != TIME:
        return format(value, form)
    return f"{value:.2f}" if value < 100.0 else f"{value:,.0f}"
