"""The page's file: the template with tables, plots, notes and data put in."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from softshadows.compare.measure import Measurement
from softshadows.compare.page.notes import sentences, technique_notes
from softshadows.compare.page.payload import payload
from softshadows.compare.page.plot import plot
from softshadows.compare.page.tables import figures_table, meanings, overall_table


def page(measurements: Sequence[Measurement], data: dict[str, Any]) -> str:
    """The page of a comparison; `data` is its results.json."""
    names = ", ".join(measurement.shot.name for measurement in measurements)
    return Template(_part("index.html")).substitute(
        title=escape(names),
        style=_part("page.css"),
        script=_part("page.js"),
        pictures="".join(map(_picture, measurements)),
        overall=overall_table(measurements),
        techniques=technique_notes(measurements),
        meanings=meanings(),
        environment=_environment(data),
        data=_in_script(payload(measurements)),
    )


def _picture(measurement: Measurement) -> str:
    """What was measured of one picture: its figures and its plot."""
    shot, reference = measurement.shot, measurement.reference
    width, height = shot.size
    lights = ", ".join(light.kind for light in shot.scene.lights)
    about = (
        f"{width} × {height} pixels, {shot.scene.triangle_count:,} triangles, "
        f"{len(shot.scene.lights)} {'light' if len(shot.scene.lights) == 1 else 'lights'} ({lights}). "
        f"Truth: {reference.samples} rays per pixel and light, standard error {reference.standard_error:.4f}, "
        f"{reference.seconds:.1f} s."
    )
    notes = sentences([*shot.notes, *measurement.skipped])
    return (
        f'<section><h2>{escape(shot.name)}</h2><p class="dim">{escape(about)}</p>{notes}'
        f"{figures_table(measurement)}{plot(measurement)}</section>"
    )


def _environment(data: dict[str, Any]) -> str:
    environment = data["environment"]
    adapter = environment["adapter"]
    versions = ", ".join(f"{name} {number}" for name, number in environment["versions"].items() if number)
    entries = {
        "adapter": f"{adapter['adapter']} ({adapter['backend']}, {adapter['driver']})",
        "processor": f"{environment['cpu']}, {environment['cpu_count']} cores",
        "system": environment["system"],
        "versions": versions,
        "commit": environment["commit"] or "–",
        "created": data["created"],
    }
    return "".join(f"<dt>{escape(name)}</dt><dd>{escape(str(value))}</dd>" for name, value in entries.items())


def _in_script(data: dict[str, Any]) -> str:
    """JSON that may stand in a script element: no `<` that could end it."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")


def _part(name: str) -> str:
    return files("softshadows.compare.page").joinpath(name).read_text(encoding="utf-8")
