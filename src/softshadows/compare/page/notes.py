"""The techniques in words: what each is, when to use it and when it fails, by its manual page, and what it did here."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

from softshadows.compare.measure import Measurement, Result
from softshadows.compare.page.payload import worst_regions
from softshadows.techniques.manual import sentence, summary

CROPS = ("visibility", "truth", "error")


def technique_notes(measurements: Sequence[Measurement]) -> str:
    """A section per technique, in the order of the tables."""
    labels = dict.fromkeys(result.label for measurement in measurements for result in measurement.results)
    return "".join(_section(label, measurements) for label in labels)


def sentences(items: Sequence[str]) -> str:
    """A list of notes, each once; empty for none."""
    listed = "".join(f"<li>{escape(sentence)}</li>" for sentence in dict.fromkeys(items))
    return f'<ul class="dim">{listed}</ul>' if listed else ""


def _section(label: str, measurements: Sequence[Measurement]) -> str:
    shown = [(i, m, r) for i, m in enumerate(measurements) for r in m.results if r.label == label]
    kind = type(shown[0][2].technique)
    says = "".join(
        f"<dt>{heading}</dt><dd>{_code(sentence(kind, heading))}</dd>"
        for heading in ("Use when", "Fails when", "Cost")
        if sentence(kind, heading)
    )
    here = "".join(_here(index, measurement, result, len(measurements) > 1) for index, measurement, result in shown)
    return f"<section><h3>{escape(label)}</h3><p>{_code(summary(kind))}</p><dl>{says}</dl>{here}</section>"


def _here(index: int, measurement: Measurement, result: Result, named: bool) -> str:
    """What a technique did on one picture: where it errs most, its warnings, and the time of its passes."""
    heading = f"<h4>{escape(measurement.shot.name)}</h4>" if named else ""
    position = measurement.results.index(result)
    crops = "".join(
        _worst(index, position, light, region, result.label, len(result.comparisons) > 1)
        for light, region in enumerate(worst_regions(measurement, result))
        if region is not None
    )
    warnings = [warning for warning in result.warnings if warning not in measurement.shot.notes]
    return f"{heading}{sentences(warnings)}{crops}{_passes(result)}"


def _worst(picture: int, technique: int, light: int, region: tuple, label: str, many_lights: bool) -> str:
    x, y, width, height, rmse = region
    of = f" of light {light}" if many_lights else ""
    where = f"{width} × {height} pixels from column {x}, row {y}"
    canvases = "".join(
        f'<figure><canvas role="img" aria-label="{escape(f"{crop}{of} by {label}, {where}")}" data-layer="{crop}">'
        f"</canvas><figcaption>{crop}</figcaption></figure>"
        for crop in CROPS
    )
    return (
        f'<div class="worst" data-picture="{picture}" data-technique="{technique}" data-light="{light}">'
        f"<p>Worst region{of}: {where}, rmse {rmse:.3f} there. <button type=button>Look there</button></p>"
        f'<div class="crops">{canvases}</div></div>'
    )


def _passes(result: Result) -> str:
    """Milliseconds by pass as bars, the longest first."""
    passes = sorted(result.stats["gpu_ms"].items(), key=lambda item: -item[1])
    if not passes:
        return ""
    most = max(passes[0][1], 1e-9)
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{ms:.2f}</td>'
        f'<td class="bar"><span style="width:{100 * ms / most:.1f}%"></span></td></tr>'
        for name, ms in passes
    )
    return (
        f"<details><summary>Milliseconds by pass, {sum(ms for _, ms in passes):.1f} in all</summary>"
        '<table class="passes"><thead><tr><th scope="col">pass</th><th scope="col">ms</th><th></th></tr></thead>'
        f"<tbody>{rows}</tbody></table></details>"
    )


def _code(text: str) -> str:
    """Escaped text with what stands between backticks as code."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))
