"""Variable penumbra after tables 1, 2 and 3 of its paper: time, reads, errors, on a figure over a floor.

The view is the scene `mannequin`. Techniques: those of table 1; 2/3/5 with maps of 512², 1024² and 2048² (table
2), and with the filter of nine taps (table 3); kernels from the light; `hard`, `pcss` and `vsm` beside them. The light
moves by a micrometre before every timed frame, and techniques take turns.

A technique's figures:

reads         from the map and its mask by a pixel that looks into it; for techniques without a mask, what they say
shadow_ms     its time less that of a frame without shadows
time_ratio    shadow_ms over that of plain 4×4 PCF
reads_ratio   reads over those of plain 4×4 PCF

Pictures, where there is a folder for them: figure 5's zooms, the shadows of the head (far) and of a foot (near).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from softshadows.report.compare import file_stem
from softshadows.report.measure import Measurement, Notice, Result, yardstick
from softshadows.report.pictures import png
from softshadows.report.results import write_bytes
from softshadows.report.suites.wedges import render_in_turns
from softshadows.scene import builtin
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique, make_technique
from softshadows.techniques.variable_penumbra.variable_penumbra import VariablePenumbra

if TYPE_CHECKING:
    from softshadows.report.suites import Settings

SIZE = (1024, 768)
"""The paper's iPad."""
UNSHADOWED, PLAIN = make_technique("none"), make_technique("pcf", {"kernel": 4, "pattern": "poisson"})
ZOOMS = {"far": (0.68, 0.44, 0.96, 0.66), "near": (0.34, 0.58, 0.62, 0.80)}
"""Left, top, right and bottom as shares of the picture: the shadows of head and hand, and of the feet."""


def techniques() -> list[Technique]:
    """The rows of the tables, the plain filter first."""
    masked: list[dict[str, Any]] = [
        {"mask": "fixed", "kernel": 4},
        {"mask": "fixed", "kernel": 7},
        {"blue_kernel": 2, "green_kernel": 3, "red_kernel": 5},
        {},
        {"blue_kernel": 2, "green_kernel": 3, "red_kernel": 5, "resolution": 512},
        {"blue_kernel": 2, "green_kernel": 3, "red_kernel": 5, "resolution": 2048},
        {"blue_kernel": 2, "green_kernel": 3, "red_kernel": 5, "edge_filter": 8},
        {"kernels": "from_light"},
    ]
    others = [make_technique("hard"), make_technique("pcss", {"blocker_samples": 16, "filter_samples": 24})]
    return [PLAIN, *(VariablePenumbra(**options) for options in masked), *others, make_technique("vsm")]


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Variable penumbra, the paper's tables on a figure over a floor, with PCF, PCSS and variance maps beside."""
    scene = builtin.mannequin()
    assert scene.camera is not None, "built-in scenes have one"
    shot = Shot("mannequin", scene, scene.camera, settings.size or SIZE)
    return [measure_tables(shot, techniques(), settings, notice)]


def measure_tables(shot: Shot, rows: list[Technique], settings: Settings, notice: Notice) -> Measurement:
    """All figures of the shot; writes its pictures. The first row is what the others are set against."""
    held = yardstick(shot, settings.samples, notice)
    frames, times, skipped = render_in_turns(shot, [UNSHADOWED, *rows], settings.repeats, notice)
    results = [held.result(row, frames[row], times[row]) for row in rows if row in frames]
    plain = next((result for result in results if result.technique == rows[0]), None)
    for result in results:
        _add_figures(result, plain, times[UNSHADOWED])
        _write_zooms(settings, result)
    return Measurement(shot, held.reference, results, skipped, {})


def _add_figures(result: Result, plain: Result | None, empty_ms: float) -> None:
    reads, shadow_ms = result.stats["lookups_per_pixel"], result.frame_ms - empty_ms
    result.figures = {"reads": reads, "shadow_ms": shadow_ms, "time_ratio": None, "reads_ratio": None}
    if plain is not None:
        result.figures["time_ratio"] = shadow_ms / (plain.frame_ms - empty_ms)
        result.figures["reads_ratio"] = reads / plain.stats["lookups_per_pixel"]


def _write_zooms(settings: Settings, result: Result) -> None:
    if settings.folder is None:
        return
    height, width = result.picture.shape[:2]
    for name, (left, top, right, bottom) in ZOOMS.items():
        zoom = result.picture[int(top * height) : int(bottom * height), int(left * width) : int(right * width)]
        write_bytes(png(zoom), settings.folder / name / f"{file_stem(result.label)}.png")
