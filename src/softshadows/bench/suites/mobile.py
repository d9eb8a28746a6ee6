"""Variable penumbra after tables 1, 2 and 3 of its paper: time, reads, errors, on a figure over a floor.

Views: the scene `mannequin`; where $SOFTSHADOWS_SCENES is set, a human body and a scan of a scorpion. Techniques: those
of table 1; 2/3/5 with maps of 512², 1024² and 2048² (table 2), and with the filter of nine taps (table 3); kernels from
the light; bands and those with two layers of the map; `hard`, `pcss` and `vsm` beside them. The light moves by a
micrometre before every timed frame, and techniques are interleaved.

A technique's figures:

reads         from the map and its mask by a pixel that looks into it; for techniques without a mask, what they say
shadow_ms     its time less that of a frame without shadows
time_ratio    shadow_ms over that of plain 4×4 PCF
reads_ratio   reads over those of plain 4×4 PCF
filter_ms     GPU time of what follows the map: mask and look-up passes, and the map's last layer; median. None without
              timestamps. On a software driver most of shadow_ms is the map's vertices
filter_ratio  filter_ms over that of plain 4×4 PCF
lookup_ms     GPU time of the look-up pass alone

Pictures of `mannequin`, where there is a folder for them: figure 5's zooms, the shadows of the head (far) and of a foot
(near).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softshadows.bench.suites.baselines import real_shots
from softshadows.compare.comparison import file_stem
from softshadows.compare.interleaved import REDRAWN, render_interleaved
from softshadows.compare.measure import Measurement, Notice, Result, measure_each, reference_frame
from softshadows.compare.pictures import png
from softshadows.compare.results import write_bytes
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Technique, make_technique
from softshadows.techniques.variable_penumbra.variable_penumbra import VariablePenumbra

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

SIZE = (1024, 768)
"""The paper's iPad."""
UNSHADOWED, PLAIN = make_technique("none"), make_technique("pcf", {"kernel": 4, "pattern": "poisson"})
ZOOMS = {"far": (0.68, 0.44, 0.96, 0.66), "near": (0.34, 0.58, 0.62, 0.80)}
"""Left, top, right and bottom as shares of `mannequin`: the shadows of head and hand, and of the feet."""
BUILTIN = "mannequin"
SHOTS = ("body", "scorpion")
"""Real models of over 50 000 vertices."""
SHARED_PASSES = frozenset({"gbuffer", "fit", "shadow_maps", "shading", "fill"})
"""What every technique with one map spends time on."""


def techniques() -> list[Technique]:
    """The rows of the tables, the plain filter first."""
    masked: list[dict[str, Any]] = [
        {"preset": "4x4"},
        {"preset": "7x7"},
        {"preset": "2/3/5"},
        {"preset": "3/5/7"},
        {"preset": "2/3/5", "resolution": 512},
        {"preset": "2/3/5", "resolution": 2048},
        {"preset": "2/3/5", "edge_filter": 8},
        {"layers": 2},
        {"kernels": "from_light"},
        {"kernels": "from_light", "layers": 2},
    ]
    others = [make_technique("hard"), make_technique("pcss", {"preset": "16/24"})]
    return [PLAIN, *(VariablePenumbra.of(options) for options in masked), *others, make_technique("vsm")]


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Variable penumbra, the paper's tables on figures over a floor, with PCF, PCSS and variance maps beside."""

    def measure_source(source: str, within: Notice) -> Measurement:
        shot = replace(open_shot(source), size=settings.size or SIZE)
        return measure_tables(shot, techniques(), settings, within)

    return measure_each(sources(), lambda source: Path(source).stem, measure_source, notice)


def sources() -> Iterator[str]:
    """The built-in figure, then the shots of $SOFTSHADOWS_SCENES; SceneError where that is a folder without any."""
    yield BUILTIN
    yield from map(str, real_shots(SHOTS))


def measure_tables(shot: Shot, rows: list[Technique], settings: Settings, notice: Notice) -> Measurement:
    """All figures of the shot; writes its pictures. The first row is what the others are set against."""
    base = reference_frame(shot, settings.samples, notice)
    runs, failed = render_interleaved(shot, [UNSHADOWED, *rows], settings.repeats, notice)
    empty_ms = next(base.result_of(run).frame_ms for run in runs if run.technique == UNSHADOWED)
    results: list[Result] = []
    for run in (run for run in runs if run.technique != UNSHADOWED):
        result = base.result_of(run)
        result.figures = _own_figures(result, empty_ms, run.pass_ms(REDRAWN))
        results.append(result)
    plain = next((result.figures for result in results if result.technique == rows[0]), None)
    for result in results:
        for ratio, figure in (("time_ratio", "shadow_ms"), ("reads_ratio", "reads"), ("filter_ratio", "filter_ms")):
            result.figures[ratio] = _ratio(result.figures[figure], plain[figure] if plain else None)
        _write_zooms(settings, shot, result)
    return Measurement(shot, base.reference, results, failed, {})


def _own_figures(result: Result, empty_ms: float, pass_ms: Mapping[str, float]) -> dict[str, Any]:
    filtering = {name: taken for name, taken in pass_ms.items() if name not in SHARED_PASSES}
    return {
        "reads": result.stats["lookups_per_pixel"],
        "shadow_ms": result.frame_ms - empty_ms,
        "filter_ms": sum(filtering.values()) if filtering else None,
        "lookup_ms": filtering.get("lookup"),
    }


def _ratio(value: float | None, plain: float | None) -> float | None:
    return value / plain if value is not None and plain else None


def _write_zooms(settings: Settings, shot: Shot, result: Result) -> None:
    if settings.folder is None or shot.name != BUILTIN:
        return
    height, width = result.picture.shape[:2]
    for name, (left, top, right, bottom) in ZOOMS.items():
        zoom = result.picture[int(top * height) : int(bottom * height), int(left * width) : int(right * width)]
        write_bytes(png(zoom), settings.folder / name / f"{file_stem(result.label)}.png")
