"""Penumbra wedges on cubes of spheres, after figures 1, 2 and 12 of their paper, against maps, rays and each other.

Views: sphere_cube_1 to _4, cubes of 1, 8, 27 and 64 spheres of 762 triangles; the one of 27 with every option of the
overlap, with `uniform` 32×32 (as many maps as the paper's reference has) and with `adaptive`. Lights move by a
micrometre before every timed frame, so that nothing is kept from the last one, and techniques are interleaved.

A technique's figures; None where something could not be measured:

time_ratio       its time over that of `additive`, the standard algorithm, both less the time of a frame without shadows
rmse_ratio       its rmse over that of `additive`
wedge_ms         its time less that of a frame without shadows
edges, triangles of the scene

The last view's figure `growth` holds triangles and wedge_ms of `overlap` in all views, and `linear_within`: the largest
departure of wedge_ms from a straight line through them, as a share.

Pictures, where there is a folder for them: per view and technique the picture, and its error times 5, orange where too
light and blue where too dark.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from softshadows import metrics
from softshadows.compare.comparison import file_stem
from softshadows.compare.interleaved import render_interleaved
from softshadows.compare.measure import Measurement, Notice, ReferenceFrame, Result, measure_each, reference_frame
from softshadows.compare.pictures import png
from softshadows.compare.results import write_bytes
from softshadows.scene import builtin
from softshadows.scene.edges import edges_of
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique, make_technique

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

SIZE = (400, 300)
"""A quarter of the paper's 800×600."""
COUNTS = (1, 2, 3, 4)
"""Spheres along a cube's side."""
FULL = 3
"""The cube that all techniques do."""
AMPLIFICATION = 5.0
UNSHADOWED, STANDARD, PAPER = make_technique("none"), "additive", "overlap"


@dataclass(frozen=True)
class View:
    """A cube of count³ spheres, and what it is rendered with; the first technique is the standard algorithm."""

    name: str
    count: int
    techniques: list[Technique]


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Penumbra wedges, four blendings and the paper's options, on cubes of spheres, with maps and rays beside."""
    measurements = measure_each(
        views(), lambda view: view.name, lambda view, within: measure_view(view, settings, within), notice
    )
    measurements[-1].figures["growth"] = growth(measurements)
    return measurements


def views() -> Iterator[View]:
    """The cubes, from one sphere on."""
    blendings = [_wedges(blending=blending) for blending in (STANDARD, "probabilistic", PAPER, "union")]
    options: list[dict[str, Any]] = [
        {"blending.rect": "paper"},
        {"preset": "paper"},
        {"blending.centre_of_gravity": True},
    ]
    others = [make_technique("uniform", {"grid": 32}), make_technique("adaptive")]
    for count in COUNTS:
        extra = [*(_wedges(**option) for option in options), *others] if count == FULL else []
        yield View(f"sphere_cube_{count}", count, [*blendings, *extra])


def _wedges(**options: Any) -> Technique:
    return make_technique("penumbra_wedges", options)


def measure_view(view: View, settings: Settings, notice: Notice) -> Measurement:
    """All figures of a view; writes its pictures. What the adapter cannot do is left out and named."""
    scene = builtin.sphere_cube(view.count)
    assert scene.camera is not None, "built-in scenes have one"
    shot = Shot(view.name, scene, scene.camera, settings.size or SIZE)
    base = reference_frame(shot, settings.samples, notice)
    runs, failed = render_interleaved(shot, [UNSHADOWED, *view.techniques], settings.repeats, notice)
    empty_ms = next(base.result_of(run).frame_ms for run in runs if run.technique == UNSHADOWED)
    edges = sum(len(edges_of(node.mesh).vertices) for node in scene.nodes)
    results: list[Result] = []
    for run in (run for run in runs if run.technique != UNSHADOWED):
        result = base.result_of(run)
        result.figures = {"wedge_ms": result.frame_ms - empty_ms, "edges": edges, "triangles": scene.triangle_count}
        results.append(result)
    standard = next((result for result in results if result.technique == view.techniques[0]), None)
    for result in results:
        result.figures["time_ratio"] = _ratio(result, standard, "wedge_ms")
        result.figures["rmse_ratio"] = result.comparisons[0].rmse / standard.comparisons[0].rmse if standard else None
        _write_pictures(settings, view, base, result)
    return Measurement(shot, base.reference, results, failed, {})


def _ratio(result: Result, standard: Result | None, figure: str) -> float | None:
    return result.figures[figure] / standard.figures[figure] if standard else None


def growth(measurements: Sequence[Measurement]) -> dict[str, Any]:
    """Time over triangles of the paper's blending, in all views, and how straight it is."""
    found = [
        (result.figures["triangles"], result.figures["wedge_ms"])
        for measurement in measurements
        for result in measurement.results
        if result.technique == _wedges(blending=PAPER)
    ]
    triangles, milliseconds = (list(values) for values in zip(*found, strict=True)) if found else ([], [])
    within = None
    if len(found) > 2:
        line = np.polynomial.Polynomial.fit(triangles, milliseconds, 1)(np.array(triangles))
        within = float(np.abs(np.array(milliseconds) / line - 1.0).max())
    return {"triangles": triangles, "wedge_ms": milliseconds, "linear_within": within}


def _write_pictures(settings: Settings, view: View, base: ReferenceFrame, result: Result) -> None:
    if settings.folder is None:
        return
    reference, stem = base.reference, file_stem(result.label)
    write_bytes(png(base.reference.picture), settings.folder / view.name / "truth.png")
    write_bytes(png(result.picture), settings.folder / view.name / f"{stem}.png")
    error = metrics.signed_error_image(
        result.visibility[0], reference.visibility[0], reference.mask[0], amplification=AMPLIFICATION
    )
    write_bytes(png(error), settings.folder / view.name / f"{stem}-error.png")
