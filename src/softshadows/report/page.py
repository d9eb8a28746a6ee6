"""The compare page: one HTML file that holds its pictures, opens anywhere and needs no network."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Any

from softshadows.report.measure import Measurement, Result
from softshadows.report.pictures import data_uri
from softshadows.report.plates import Plates, explanation

STYLE = """
:root { color-scheme: light dark; --rule: #8884; --soft: #8882; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1500px; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.15rem; margin: 2.2rem 0 0.4rem; }
.dim { opacity: 0.7; } code { font-size: 0.92em; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1rem 0; }
th, td { padding: 0.3rem 0.7rem; text-align: right; border-bottom: 1px solid var(--rule); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } tbody tr:hover { background: var(--soft); }
td.best { font-weight: 700; }
.plates { display: grid; grid-template-columns: repeat(auto-fit, minmax(210px, 1fr)); gap: 0.8rem; }
figure { margin: 0; }
figure img { width: 100%; display: block; border: 1px solid var(--rule); border-radius: 4px; box-sizing: border-box; }
figcaption { font-size: 0.85em; opacity: 0.8; padding-top: 0.2rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.2rem 1rem; }
dt { font-weight: 600; } dd { margin: 0; }
"""

COLUMNS: list[tuple[str, str, str]] = [
    # heading, format, what it means
    ("shadow maps", "d", "shadow maps drawn for the frame, all lights together"),
    ("ms", ".1f", "median wall time of a repeated frame and its read-back; what did not change may be cached"),
    ("rmse", ".4f", "root mean square of visibility − truth"),
    ("penumbra rmse", ".4f", "the same over pixels whose true visibility lies between 0.02 and 0.98"),
    ("bias", "+.4f", "mean of visibility − truth: positive is too light"),
    ("p99", ".3f", "99th percentile of the absolute error"),
    ("leak rate", ".2%", "share of true umbra pixels with visibility above 0.1"),
    ("false shadow", ".2%", "share of truly lit pixels with visibility below 0.9"),
    ("penumbra width", "+.1%", "relative error of the penumbra's width: positive is too wide"),
    ("FLIP", ".4f", "perceived difference of the finished pictures, 0 alike to 1"),
]


def page(measurement: Measurement, plates: dict[str, Plates], data: dict[str, Any]) -> str:
    """The page for one measurement; `plates` are its pictures by technique label, `data` its results.json."""
    shot, reference = measurement.shot, measurement.reference
    width, height = shot.size
    about = (
        f"{width} × {height} pixels, {shot.scene.triangle_count:,} triangles, "
        f"{', '.join(light.kind for light in shot.scene.lights)} light. "
        f"Truth: {reference.samples} rays per pixel and light, standard error {reference.standard_error:.4f}, "
        f"{reference.seconds:.1f} s."
    )
    meanings = "".join(f"<dt>{escape(name)}</dt><dd>{escape(says)}</dd>" for name, _, says in COLUMNS)
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>softshadows: {escape(shot.name)}</title><style>{STYLE}</style></head><body>
<h1>{escape(shot.name)}</h1><p class="dim">{escape(about)}</p>
{_notes([*shot.notes, *measurement.skipped])}
{_table(measurement)}
{"".join(_section(result, plates[result.label]) for result in measurement.results)}
<h2>What the columns say</h2><dl>{meanings}</dl>
<p>{escape(explanation())}</p>
<h2>Measured on</h2><dl>{_environment(data["environment"])}<dt>created</dt><dd>{escape(data["created"])}</dd></dl>
</body></html>
"""


def row_values(result: Result, light: int) -> list[float | None]:
    """The figures of `COLUMNS` for one light of a result."""
    comparison = result.comparisons[light]
    return [
        result.stats["shadow_maps"],
        result.frame_ms,
        comparison.rmse,
        comparison.penumbra_rmse,
        comparison.bias,
        comparison.p99,
        comparison.leak_rate,
        comparison.false_shadow_rate,
        comparison.penumbra_width_error,
        result.flip,
    ]


def _table(measurement: Measurement) -> str:
    """A row per technique and light; the smallest error of each column in bold."""
    lights = len(measurement.shot.scene.lights)
    rows = []
    for light in range(lights):
        values = [row_values(result, light) for result in measurement.results]
        best = [min((abs(v) for v in column if v is not None), default=None) for column in zip(*values, strict=True)]
        for result, row in zip(measurement.results, values, strict=True):
            name = escape(result.label) + (f", light {light}" if lights > 1 else "")
            cells = [
                f"<td{_best(position, value, best[position])}>{'–' if value is None else format(value, form)}</td>"
                for position, (value, (_, form, _)) in enumerate(zip(row, COLUMNS, strict=True))
            ]
            rows.append(f"<tr><td>{name}</td>{''.join(cells)}</tr>")
    head = "".join(f'<th title="{escape(says)}">{escape(name)}</th>' for name, _, says in COLUMNS)
    return (
        f'<div class="scroll"><table><thead><tr><th>technique</th>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


def _best(position: int, value: float | None, best: float | None) -> str:
    is_error = position >= 2
    return ' class="best"' if is_error and value is not None and best is not None and abs(value) <= best else ""


def _section(result: Result, plates: Plates) -> str:
    figures = "".join(
        f'<figure><img alt="{escape(caption)}" src="{data_uri(image)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, image in plates
    )
    return f'<h2>{escape(result.label)}</h2>{_notes(result.warnings)}<div class="plates">{figures}</div>'


def _notes(sentences: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f'<ul class="dim">{items}</ul>' if items else ""


def _environment(environment: dict[str, Any]) -> str:
    adapter = environment["adapter"]
    versions = ", ".join(f"{name} {number}" for name, number in environment["versions"].items() if number)
    entries = {
        "adapter": f"{adapter['adapter']} ({adapter['backend']}, {adapter['driver']})",
        "processor": f"{environment['cpu']}, {environment['cpu_count']} cores",
        "system": environment["system"],
        "versions": versions,
        "commit": environment["commit"] or "–",
    }
    return "".join(f"<dt>{escape(name)}</dt><dd>{escape(str(value))}</dd>" for name, value in entries.items())
