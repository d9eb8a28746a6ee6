"""Adaptive light sampling against 289 maps, PCSS, the truth and rays: views after figures 1 and 7 to 10 of its paper.

Views: a scene with the paper's modest light from far and from near, with PCSS beside; the atrium with the whole and
with half the comparison; where $SOFTSHADOWS_SCENES is set, real scenes with the default refinement.

Every technique is timed in two ways, interleaved with the others, as wall time of `Renderer.render`:

redrawn    the light moves by a micrometre before the frame, so that every shadow map is drawn
kept       the light rests and the camera moves to and fro by a millimetre, so that maps may be kept; only where the
           resolution is fixed

A technique's figures, the means over its lights, and None where something could not be measured:

lookups                    per pixel
time_ratio_redrawn, _kept  the time of `uniform` 17×17 at the same resolution, in the same mode, over this one's
compare_share              share of the redrawn frame's GPU time in the passes called "compare"
rmse_truth, penumbra_rmse_truth, rmse_uniform, penumbra_rmse_uniform
                           to the truth and to that `uniform`: over facing pixels, and over those in penumbra
equal_rays                 stratified shadow rays per facing pixel whose rmse to the truth is the same
equal_rays_bound           "at most" or "at least", where that lies beyond RAYS
ray_time_ratio_redrawn, _kept
                           the time of so many rays on all of this machine's cores, over this technique's. Rays alone:
                           no acceleration structure is built in it
redrawn, kept              median wall_ms, gpu_ms by pass; in `times`, "frame" is redrawn

A picture's figure `rays` holds samples, rmse and seconds of every number of rays. Pictures, where there is a folder for
them: per view and technique the picture, its difference to the picture by `uniform` times 5 and times 40, and what
techniques/adaptive/pictures.py shows.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from softshadows import metrics, truth
from softshadows.bench.suites.baselines import real_shots
from softshadows.compare.comparison import file_stem
from softshadows.compare.interleaved import CACHED, REDRAWN, Run, render_interleaved
from softshadows.compare.measure import Measurement, Notice, ReferenceFrame, Result, measure_each, reference_frame
from softshadows.compare.pictures import png
from softshadows.compare.results import write_bytes
from softshadows.scene import builtin
from softshadows.scene.camera import Camera
from softshadows.scene.lights import RectLight
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Technique, make_technique
from softshadows.techniques.adaptive.pictures import all_pictures

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

Pictures = dict[str, npt.NDArray[np.float32]]
"""Debug pictures by name."""

SIZE = (512, 384)
"""Half the width and height of the paper's, which `--size 1024x768` asks for: minutes instead of half an hour on two
cores without a GPU."""
MAP = 512
"""Texels along a shadow map's side: the paper's."""
MODEST = RectLight((1.6, 3.6, 1.4), (0.0, 0.3, 0.2), 0.2, 0.2, (1580.0, 1540.0, 1460.0))
"""The light of `figures`, 0.2 m wide instead of 0.9 m, and as bright in all."""
FAR = Camera((2.88, 6.25, 10.4), (0.12, 0.35, 0.2), 40.0)
NEAR = Camera((1.25, 2.3, 2.3), (1.1, 0.05, 1.7), 40.0)
"""Where the paper's global refinement takes 25 and 81 maps at 1024×768 (figure 1: 25 and 105)."""
SHOTS = ("scorpion", "body", "bike_near", "sponza_near", "sponza")
RAYS = (4, 9, 16, 25, 36, 64, 100, 144, 256)
RAY_SEED = 1
"""Not the truth's, whose errors would be the same."""
AMPLIFICATIONS = (5, 40)
"""Factors on the paper's difference images: figures 7 and 10."""


@dataclass(frozen=True)
class View:
    """A shot, and what it is rendered with: groups of techniques, each led by the `uniform` to compare with."""

    name: str
    open: Callable[[], Shot]
    groups: list[list[Technique]]


@dataclass(frozen=True)
class Rays:
    """Stratified rays on all cores: their rmse to the truth by number per pixel, and milliseconds for one per pixel."""

    samples: list[int]
    rmse: list[float]
    seconds: list[float]

    @property
    def ms_per_sample(self) -> float:
        """The slope of seconds over samples, which leaves out what is done once; over all, where noise hides it."""
        slope = float(np.polyfit(self.samples, self.seconds, 1)[0])
        return 1e3 * (slope if slope > 0.0 else self.seconds[-1] / self.samples[-1])

    @property
    def series(self) -> list[dict[str, float]]:
        """By number of rays, as results.json has them."""
        return [
            {"samples": samples, "rmse": rmse, "seconds": seconds}
            for samples, rmse, seconds in zip(self.samples, self.rmse, self.seconds, strict=True)
        ]

    def equal_to(self, rmse: float) -> tuple[float, str | None]:
        """How many rays have that rmse, interpolated on logarithmic scales; beyond RAYS their end, and the side."""
        errors = np.maximum(np.minimum.accumulate(self.rmse), 1e-12)
        if rmse >= errors[0]:
            return float(self.samples[0]), "at most" if rmse > errors[0] else None
        if rmse < errors[-1]:
            return float(self.samples[-1]), "at least"
        falling = np.concatenate([[True], np.diff(errors) < 0.0])
        logs = np.log(errors[falling])[::-1], np.log(np.array(self.samples)[falling])[::-1]
        return float(np.exp(np.interp(np.log(rmse), *logs))), None


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Adaptive light sampling against 289 maps, PCSS, the truth and rays, on views after its paper's figures."""
    return measure_each(
        views(), lambda view: view.name, lambda view, within: measure_view(view, settings, within), notice
    )


def views() -> Iterator[View]:
    """The built-in views, then those of $SOFTSHADOWS_SCENES; SceneError where that is set to a folder without any."""
    uniform, paper = _make("uniform", resolution=MAP), {"refinement": "global", "resolution": MAP}
    tile, whole = _make("adaptive", resolution=MAP), _make("adaptive", **paper)
    half = _make("adaptive", comparison_scale=0.5, filter="pcf", **paper)
    for name, camera in (("far", FAR), ("near", NEAR)):
        pcss = _make("pcss", blocker_samples=64, filter_samples=64, resolution=MAP)
        yield View(name, lambda name=name, camera=camera: _modest(name, camera), [[uniform, whole, tile, pcss]])
    yield View("atrium", lambda: open_shot("atrium"), [[uniform, whole, half, tile]])
    cells = _make("adaptive", filter="cell", max_depth=2, resolution=MAP)
    for file in real_shots(SHOTS):
        groups = [[uniform, tile, cells], [_make("uniform"), _make("adaptive")]]
        yield View(file.stem, lambda file=file: open_shot(str(file)), groups)


def _make(name: str, **options: Any) -> Technique:
    return make_technique(name, options)


def _modest(name: str, camera: Camera) -> Shot:
    """`figures` under the modest light."""
    scene = builtin.figures()
    scene.lights, scene.camera = [MODEST], camera
    return Shot(name, scene, camera, SIZE)


def measure_view(view: View, settings: Settings, notice: Notice) -> Measurement:
    """All figures of a view; writes its pictures. What the adapter cannot do is left out and named."""
    shot = replace(view.open(), name=view.name, size=settings.size or SIZE)
    base = reference_frame(shot, settings.samples, notice)
    notice("tracing shadow rays", 0.1)
    rays = trace(shot, base)
    results: list[Result] = []
    skipped: list[str] = []
    if settings.folder is not None:
        write_bytes(png(base.reference.picture), settings.folder / view.name / "truth.png")
    for number, group in enumerate(view.groups):

        def within(doing: str, share: float, number: int = number) -> None:
            notice(doing, 0.2 + 0.8 * (number + share) / len(view.groups))

        pictures: dict[Technique, Pictures] = {}

        def take_pictures(run: Run, taken: dict[Technique, Pictures] = pictures) -> None:
            if settings.folder is not None and run.technique.name == "adaptive":
                taken[run.technique] = all_pictures(run.renderer)

        runs, failed = render_interleaved(
            shot, group, settings.repeats, within, keeps=caches_maps, after_first=take_pictures
        )
        skipped += failed
        if runs and runs[0].technique == group[0]:
            made = [_result(run, runs[0], base, rays) for run in runs]
            results += made
            if settings.folder is not None:
                for run, result in zip(runs, made, strict=True):
                    _write_pictures(settings.folder / view.name, pictures.get(run.technique, {}), result, made[0])
    return Measurement(shot, base.reference, results, skipped, {"rays": rays.series})


def caches_maps(technique: Technique) -> bool:
    """Only maps of a fixed resolution are the same size whoever draws them."""
    return getattr(technique, "resolution", None) != "auto"


def timings(run: Run, mode: str) -> dict[str, Any] | None:
    """Medians of a run's frames as results.json has them; None where the mode was not measured."""
    timing = run.timing(mode)
    return {"wall_ms": timing.median_ms, "gpu_ms": run.pass_ms(mode)} if timing else None


@dataclass(frozen=True, eq=False)
class FacingSurfaces:
    """A frame's surfaces, without those that face no light (truth.visibility's `frame`)."""

    position: npt.NDArray[np.float32]
    normal: npt.NDArray[np.float32]
    surface: npt.NDArray[np.bool_]


def facing_surfaces(base: ReferenceFrame) -> FacingSurfaces:
    """Those that some light reaches."""
    return FacingSurfaces(base.frame.position, base.frame.normal, np.asarray(base.reference.mask.any(axis=0)))


def trace(shot: Shot, base: ReferenceFrame, counts: Sequence[int] = RAYS) -> Rays:
    """What so many shadow rays per facing pixel cost and how far they are from the truth."""
    mask, seen = base.reference.mask, facing_surfaces(base)
    errors, seconds = [], []
    for samples in counts:
        started = time.perf_counter()
        visibility = truth.visibility(shot.scene, seen, samples=samples, seed=RAY_SEED)
        seconds.append(time.perf_counter() - started)
        compared = [metrics.compare(*light) for light in zip(visibility, base.reference.visibility, mask, strict=True)]
        errors.append(_mean(compared, "rmse"))
    return Rays(list(counts), errors, seconds)


def timed_result(run: Run, base: ReferenceFrame) -> Result:
    """A technique's errors, and its times in both modes, which are its only figures yet."""
    redrawn, kept, cached_timing = timings(run, REDRAWN), timings(run, CACHED), run.timing(CACHED)
    result = base.result_of(run)
    if cached_timing is not None:
        result.times[CACHED] = cached_timing
    result.stats["gpu_ms"] = run.pass_ms(REDRAWN)
    result.figures = {REDRAWN: redrawn, CACHED: kept}
    return result


def result_beside_rays(run: Run, base: ReferenceFrame, rays: Rays) -> Result:
    """A technique's errors and times, and the rays that err as much: the figures that need no other technique."""
    result = timed_result(run, base)
    redrawn, kept = result.figures[REDRAWN], result.figures[CACHED]
    error = _mean(result.comparisons, "rmse")
    equal, bound = rays.equal_to(error)
    ray_ms = equal * rays.ms_per_sample
    result.figures = {
        "lookups": run.frame.stats.lookups_per_pixel,
        "rmse_truth": error,
        "penumbra_rmse_truth": _mean(result.comparisons, "penumbra_rmse"),
        "equal_rays": equal,
        "equal_rays_bound": bound,
        "ray_time_ratio_redrawn": ray_ms / redrawn["wall_ms"],
        "ray_time_ratio_cached": ray_ms / kept["wall_ms"] if kept else None,
        **result.figures,
    }
    return result


def _result(run: Run, baseline: Run, base: ReferenceFrame, rays: Rays) -> Result:
    result = result_beside_rays(run, base, rays)
    redrawn, kept = result.figures[REDRAWN], result.figures[CACHED]
    uniform = [
        metrics.compare(*light)
        for light in zip(run.frame.visibility, baseline.frame.visibility, base.reference.mask, strict=True)
    ]
    gpu_ms = sum(redrawn["gpu_ms"].values())
    result.figures |= {
        "time_ratio_redrawn": time_ratio(timings(baseline, REDRAWN), redrawn),
        "time_ratio_cached": time_ratio(timings(baseline, CACHED), kept),
        "compare_share": redrawn["gpu_ms"].get("compare", 0.0) / gpu_ms if gpu_ms else None,
        "rmse_uniform": _mean(uniform, "rmse"),
        "penumbra_rmse_uniform": _mean(uniform, "penumbra_rmse"),
    }
    return result


def time_ratio(a: dict[str, Any] | None, b: dict[str, Any] | None) -> float | None:
    """The wall time of `a` over that of `b`, two timings; None where one was not measured."""
    return a["wall_ms"] / b["wall_ms"] if a and b else None


def _mean(comparisons: Sequence[metrics.Comparison], name: str) -> float:
    return statistics.fmean(getattr(comparison, name) for comparison in comparisons)


def _write_pictures(folder: Path, pictures: Pictures, result: Result, baseline: Result) -> None:
    stem = file_stem(result.label)
    write_bytes(png(result.picture), folder / f"{stem}.png")
    if result is not baseline:
        apart = np.abs(result.picture.astype(np.float64) - baseline.picture) / 255.0
        for times in AMPLIFICATIONS:
            write_bytes(png(times * apart), folder / f"{stem}-difference-x{times}.png")
    for name, picture in pictures.items():
        write_bytes(png(picture), folder / f"{stem}-{name}.png")
