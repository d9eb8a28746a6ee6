"""Line lights: two and more point lights, soft shadow maps, occluding edges, the truth and rays, after the two papers.

Views: `figures`, `fence`, `sphere_cube` and `atrium` under a line light; where $SOFTSHADOWS_SCENES is set, real scenes
with their own line lights; "triangle", `figures` under the three sides of a triangle, as Heidrich et al. shadow a
triangular light. Then what occluding edges cost: "resolution", with maps of 200² to 2000² texels (figure 9 of their
paper), and "triangles N", over the number of triangles.

Frames are timed as in the suite `adaptive`, redrawn and kept, interleaved. A technique's figures:

rmse_truth, penumbra_rmse_truth   to the truth: over facing pixels, and over those in penumbra
leak_rate                         share of umbra pixels with visibility above 0.1
time_over_hard                    wall time of a frame over that of two hard shadows, from the light's ends, at the same
                                  resolution where that is fixed; all is redrawn
cached_over_hard                  the same with maps cached from the frame before; None where no resolution is fixed
outreach_share                    share of GPU time that occluding edges spend on their outreach; None for others
equal_uniform                     evenly spaced point lights that have the same rmse, interpolated; None without them
equal_rays                        stratified shadow rays per facing pixel with the same rmse
equal_uniform_bound, equal_rays_bound   "at most" or "at least", where that lies beyond those measured
redrawn, kept                     median wall_ms, gpu_ms by pass
rmse_area                         of "triangle": the mean of the sides' visibility to the truth of the triangle itself

A picture's figure `rays` holds samples, rmse and seconds of every number of rays, 10 and 200 among them; that of
"triangle" also, as `outline_rmse`, the distance of its sides' truth from its own.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from softshadows.bench.suites.adaptive import (
    Rays,
    caches_maps,
    time_ratio,
    timed_result,
    timings,
    trace,
)
from softshadows.bench.suites.baselines import SIZE, real_shots
from softshadows.bench.suites.triangle import Triangle
from softshadows.compare.comparison import file_stem
from softshadows.compare.interleaved import CACHED, REDRAWN, Run, render_interleaved
from softshadows.compare.measure import Measurement, Notice, ReferenceFrame, Result, measure_each, reference_frame
from softshadows.compare.pictures import png
from softshadows.compare.results import write_bytes
from softshadows.scene import builtin
from softshadows.scene.lights import LineLight
from softshadows.scene.model import Scene
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import LineShadowMaps, OccludingEdges, Technique, Uniform

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

BUILTIN = ("figures", "fence", "sphere_cube", "atrium")
SHOTS = ("chair_line", "bike_line", "classroom_tube")
POINT_LIGHTS = (2, 3, 5, 9, 17)
"""Evenly spaced on the line, its ends included."""
RAYS = (2, 4, 10, 25, 50, 100, 200)
"""10 and 200 are those of Heidrich et al.'s comparison."""
RESOLUTIONS = (200, 500, 800, 1200, 1600, 2000)
"""Reimann and Dreier's figure 9 runs from 200 to 2000."""
SPHERES = (1, 2, 5, 11)
"""Along each side of the cube: 10³ to 10⁶ triangles."""


@dataclass(frozen=True)
class View:
    """A shot, and its techniques; each is timed against two point lights at its resolution.

    `triangle` is the light whose sides are the shot's, where there is one.
    """

    name: str
    open: Callable[[], Shot]
    techniques: list[Technique]
    triangle: Triangle | None = None


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Line lights: point lights, soft shadow maps and occluding edges against the truth, and what edges cost."""
    return measure_each(
        views(), lambda view: view.name, lambda view, within: measure_view(view, settings, within), notice
    )


def views() -> Iterator[View]:
    """The comparisons, then the costs; SceneError where $SOFTSHADOWS_SCENES is set to a folder without any."""
    for name in BUILTIN:
        yield View(name, partial(under_a_line, name, getattr(builtin, name)()), methods())
    for file in real_shots(SHOTS):
        yield View(file.stem, partial(open_shot, str(file)), methods())
    scene = builtin.figures()
    triangle = Triangle.within(scene.lights[0])
    yield View("triangle", partial(triangle.lit_by_sides, scene, "triangle", SIZE), methods(), triangle)
    by_resolution: list[Technique] = []
    for resolution in RESOLUTIONS:
        by_resolution += [_point_lights(2, resolution), replace(OccludingEdges.preset("paper"), resolution=resolution)]
    yield View("resolution", partial(under_a_line, "resolution", builtin.figures()), by_resolution)
    for count in SPHERES:
        scene = builtin.sphere_cube(count)
        edges = OccludingEdges.preset("paper")
        yield View(
            f"triangles {scene.triangle_count}",
            partial(under_a_line, f"triangles {scene.triangle_count}", scene),
            [_point_lights(2, edges.resolution), edges],
        )


def methods() -> list[Technique]:
    """Point lights, and both methods with two and three samples and mended."""
    maps, edges = LineShadowMaps.preset("paper"), OccludingEdges.preset("paper")
    return [
        *(_point_lights(count) for count in POINT_LIGHTS),
        *(_point_lights(2, paper.resolution) for paper in (maps, edges)),
        maps,
        replace(maps, samples=3),
        LineShadowMaps(),
        edges,
        replace(edges, samples=3),
        OccludingEdges(),
        OccludingEdges(samples=9),
    ]


def _point_lights(count: int, resolution: int | str = "auto") -> Technique:
    return Uniform(grid=count, resolution=resolution)


def under_a_line(name: str, scene: Scene) -> Shot:
    """The scene under a line as long as its light is wide, and as bright in all."""
    light = scene.lights[0]
    reach = light.axes[0] * light.half_extent[0]
    height = 2.0 * light.half_extent[1]
    emission = tuple(height * channel for channel in light.emission)
    start, end = (tuple((light.center + side * reach).tolist()) for side in (-1.0, 1.0))
    scene.lights = [LineLight(start, end, emission)]  # type: ignore[arg-type]
    assert scene.camera is not None
    return Shot(name, scene, scene.camera, SIZE)


def measure_view(view: View, settings: Settings, notice: Notice) -> Measurement:
    """All figures of a view; writes its pictures. What the adapter cannot do is left out and named."""
    shot = replace(view.open(), name=view.name, size=settings.size or SIZE)
    base = reference_frame(shot, settings.samples, notice)
    notice("tracing shadow rays", 0.15)
    rays = trace(shot, base, RAYS)
    runs, skipped = render_interleaved(shot, view.techniques, settings.repeats, notice, keeps=caches_maps)
    results = [_result(run, _baseline(run, runs), base) for run in runs]
    plain = _plain(results)
    for result in results:
        error = result.figures["rmse_truth"]
        equal, bound = plain.equal_to(error) if plain else (None, None)
        result.figures["equal_uniform"], result.figures["equal_uniform_bound"] = equal, bound
        result.figures["equal_rays"], result.figures["equal_rays_bound"] = rays.equal_to(error)
    figures: dict[str, Any] = {"rays": rays.series}
    if view.triangle is not None:
        own = view.triangle.truth(shot, base)
        figures["outline_rmse"] = view.triangle.rmse(base.reference.visibility, own, base)
        for result in results:
            result.figures["rmse_area"] = view.triangle.rmse(result.visibility, own, base)
    if settings.folder is not None:
        write_bytes(png(base.reference.picture), settings.folder / view.name / "truth.png")
        for result in results:
            write_bytes(png(result.picture), settings.folder / view.name / f"{file_stem(result.label)}.png")
    return Measurement(shot, base.reference, results, skipped, figures)


def _baseline(run: Run, runs: Sequence[Run]) -> Run | None:
    """Two point lights at the technique's resolution, or at the automatic one."""
    pairs = [other for other in runs if isinstance(other.technique, Uniform) and other.technique.grid == 2]
    same = [other for other in pairs if other.technique.resolution == getattr(run.technique, "resolution", None)]  # type: ignore[attr-defined]
    return next(iter(same or pairs), None)


def _result(run: Run, baseline: Run | None, base: ReferenceFrame) -> Result:
    result = timed_result(run, base)
    redrawn, kept = result.figures[REDRAWN], result.figures[CACHED]
    gpu_ms = sum(redrawn["gpu_ms"].values())
    outreach = redrawn["gpu_ms"].get("outreach")

    def mean(name: str) -> float:
        return statistics.fmean(getattr(comparison, name) for comparison in result.comparisons)

    result.figures = {
        "rmse_truth": mean("rmse"),
        "penumbra_rmse_truth": mean("penumbra_rmse"),
        "leak_rate": mean("leak_rate"),
        "time_over_hard": time_ratio(redrawn, baseline and timings(baseline, REDRAWN)),
        "cached_over_hard": time_ratio(kept, baseline and timings(baseline, CACHED)),
        "outreach_share": outreach / gpu_ms if outreach and gpu_ms else None,
        **result.figures,
    }
    return result


def _plain(results: Sequence[Result]) -> Rays | None:
    """The errors of point lights by their number, where there are several numbers of them."""
    found = {
        result.technique.grid: result.figures["rmse_truth"]
        for result in results
        if isinstance(result.technique, Uniform) and result.technique.resolution == "auto"
    }
    counts = sorted(found)
    return Rays(counts, [found[count] for count in counts], [0.0] * len(counts)) if len(counts) > 1 else None
