"""Rays on the GPU: as fast as Embree's and the same answers? And rays alone, or only where maps are not certain.

Pictures: where $SOFTSHADOWS_SCENES is set real scenes under rectangle and line lights, else built-in ones; then hills
of 10⁴ and 10⁵ triangles, for which trees are built. (10⁶: `time_tree(terrain(1_000_000), "gpu")` of tree_times.py.)

A picture's figures, from the same stratified shadow rays by Embree and the GPU, interleaved, some at a time:

segments                       how many
embree_per_second              on all cores, called from numpy
embree_build_ms                its acceleration structure, from triangles in world space
gpu_per_second                 with the answers' way back
ratio                          of the two
disagreeing                    rays with another answer
farthest_from_edge             how far one of them has to be shifted, in shares of the scene's diagonal, for Embree's
                               answer to change; None for none
cpu_build_ms, gpu_build_ms     a tree's shape and boxes (hills)
cpu_refit_ms                   the boxes alone (hills)
rays                           samples, rmse and seconds of stratified rays by Embree

A technique's, timed as in `adaptive.py`, `uniform` alone with cached maps; before a redrawn frame the node with most
triangles moves too, so that trees are fitted and everything is dynamic:

lookups                        per pixel: rays, or looks into maps, or both
rmse_truth, penumbra_rmse_truth, equal_rays, equal_rays_bound, ray_time_ratio_redrawn, _kept, redrawn, kept
                               see adaptive.py
dynamic_ratio                  Embree's time to build and to cast equal_rays, none of them made in it, over a redrawn
                               frame's, which begins with the scene's nodes and ends with a picture read back
rmse_over_rays, time_over_rays hybrid's error and kept time over those of the same technique by rays alone
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from softshadows.bench.suites.adaptive import (
    FacingSurfaces,
    facing_surfaces,
    result_beside_rays,
    trace,
)
from softshadows.bench.suites.baselines import real_shots
from softshadows.bench.tree_times import OVER_HILLS, SUN, terrain, time_tree
from softshadows.compare.interleaved import CACHED, REDRAWN, render_interleaved
from softshadows.compare.measure import Measurement, Notice, Result, measure_each, reference_frame
from softshadows.scene.geometry import flatten
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Adaptive, Hybrid, Rays, Technique, Uniform
from softshadows.truth.gpu_occluders import GpuOccluders
from softshadows.truth.occluders import Occluders
from softshadows.truth.segments import Receivers, Segments, cells_of, stratified
from softshadows.truth.visibility import processors

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

SIZE = (256, 192)
"""So that it takes minutes on two cores without a GPU; `--size 512x384 --repeats 1` takes twice as long."""
BUILTIN = ("figures", "leaves")
SHOTS = (
    "scorpion",
    "body",
    "bike",
    "bike_near",
    "sponza",
    "sponza_near",
    "classroom",
    "chair_line",
    "classroom_tube",
)
HILLS = (10_000, 100_000)
MAP = 512
"""Texels along a side of hybrid's maps: of fixed size they are kept, and all lie in the atlas."""
TECHNIQUES: tuple[Technique, ...] = (
    Adaptive(visibility="ray"),
    Adaptive(visibility=Rays(offsets="stratified", denoise=True), max_depth=2),
    Uniform(visibility="ray", grid=9),
    Uniform(visibility="hybrid", grid=9, resolution=MAP),
)
RAYS = (4, 16, 36, 64, 144, 256)
"""Per pixel: the errors of the techniques lie among theirs."""
SEGMENTS = 1_700_000
"""Least number of rays for each picture: 10⁷ for the six shots."""
AT_ONCE = 1 << 18
"""Segments before it is the other's turn."""
PARTS = 4
"""For each core, so that none waits long for the others."""
SEED = 2
SHIFTS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Shifts of a disagreeing ray, in shares of the scene's diagonal."""
SHIFTED = 64
"""Rays around it for each of them."""


@dataclass(frozen=True)
class View:
    """A shot, its techniques, and whether its trees are timed too."""

    name: str
    open: Callable[[], Shot]
    techniques: Sequence[Technique]
    times_trees: bool = False


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Rays on the GPU against Embree and against shadow maps, and what their trees cost."""
    return measure_each(
        views(), lambda view: view.name, lambda view, within: measure_view(view, settings, within), notice
    )


def views() -> Iterator[View]:
    """The scenes, then the hills; SceneError where $SOFTSHADOWS_SCENES is set to a folder without any."""
    for source in list(map(str, real_shots(SHOTS))) or BUILTIN:
        shot = open_shot(source)
        yield View(shot.name, lambda shot=shot: shot, TECHNIQUES)
    for triangles in HILLS:
        name = f"hills, {triangles} triangles"
        yield View(name, partial(hills, name, triangles), (Adaptive(visibility="ray"),), times_trees=True)


def hills(name: str, triangles: int) -> Shot:
    """A terrain under a low light."""
    scene = terrain(triangles)
    scene.lights, scene.camera = [SUN], OVER_HILLS
    return Shot(name, scene, OVER_HILLS, SIZE)


def measure_view(view: View, settings: Settings, notice: Notice, segments: int = SEGMENTS) -> Measurement:
    """All figures of a view, at least so many segments' among them."""
    shot = replace(view.open(), name=view.name, size=settings.size or SIZE)
    base = reference_frame(shot, settings.samples, notice)
    notice("tracing shadow rays", 0.2)
    rays = trace(shot, base, RAYS)
    notice("the same rays by Embree and the GPU", 0.3)
    figures = cast_by_both(shot, facing_surfaces(base), segments)
    if view.times_trees:
        cpu, gpu = (time_tree(shot.scene, builder) for builder in ("cpu", "gpu"))
        figures |= {"cpu_build_ms": cpu.build_ms, "gpu_build_ms": gpu.build_ms, "cpu_refit_ms": cpu.follow_ms}
    runs, skipped = render_interleaved(
        shot,
        view.techniques,
        settings.repeats,
        lambda doing, share: notice(doing, 0.4 + 0.6 * share),
        keeps=lambda technique: technique.name == "uniform",
        moves_scene=True,
    )
    results = [result_beside_rays(run, base, rays) for run in runs]
    receivers = int(np.count_nonzero(base.reference.mask))
    for result in results:
        cast_ms = 1e3 * result.figures["equal_rays"] * receivers / figures["embree_per_second"]
        dynamic_ms = figures["embree_build_ms"] + cast_ms
        result.figures["dynamic_ratio"] = dynamic_ms / result.figures[REDRAWN]["wall_ms"]
    _hold_against_rays(results)
    return Measurement(shot, base.reference, results, skipped, {**figures, "rays": rays.series})


def _hold_against_rays(results: Sequence[Result]) -> None:
    """Give hybrid techniques their figures over rays alone."""
    figures = {result.technique: result.figures for result in results}
    for technique, own in figures.items():
        if isinstance(getattr(technique, "visibility", None), Hybrid):
            rays = figures.get(replace(technique, visibility=Rays(), resolution="auto"))  # type: ignore[call-arg]
            if rays is not None:
                own["rmse_over_rays"] = own["rmse_truth"] / rays["rmse_truth"]
                own["time_over_rays"] = own[CACHED]["wall_ms"] / rays[CACHED]["wall_ms"]


def cast_by_both(shot: Shot, frame: FacingSurfaces, least: int) -> dict[str, Any]:
    """At least so many shadow rays of a frame, by Embree and by the GPU, interleaved."""
    geometry, receivers = flatten(shot.scene), Receivers.of(frame)
    started = time.perf_counter()
    embree = Occluders(geometry)
    build_seconds = time.perf_counter() - started
    gpu = GpuOccluders(geometry)
    count = embree_seconds = 0.0
    disagreeing: list[Segments] = []
    with ThreadPoolExecutor(processors()) as pool:
        for number, segments in enumerate(_segments(shot, receivers, embree, least)):
            if number == 0:
                gpu.blocked_from(segments.start, segments.rays, segments.t_max)  # compiles
                gpu.seconds = 0.0
            parts = _split(segments, PARTS * processors())
            started = time.perf_counter()
            by_embree = np.concatenate(list(pool.map(lambda part: part.visible(embree), parts)))
            embree_seconds += time.perf_counter() - started
            by_gpu = segments.visible(gpu)
            disagreeing.append(those_of(segments, by_embree != by_gpu))
            count += segments.t_max.size
    distances = [distance_to_change(embree, each) for some in disagreeing for each in _split(some, len(some.start))]
    return {
        "segments": int(count),
        "embree_build_ms": 1e3 * build_seconds,
        "embree_per_second": count / embree_seconds,
        "gpu_per_second": count / gpu.seconds,
        "ratio": embree_seconds / gpu.seconds,
        "disagreeing": len(distances),
        "farthest_from_edge": max(distances, default=None),
    }


def _segments(shot: Shot, receivers: Receivers, embree: Occluders, least: int) -> Iterator[Segments]:
    """Stratified rays from all receivers to each light, some at a time."""
    lights = shot.scene.lights
    for index, light in enumerate(lights):
        cells = cells_of(light, -(-least // (max(receivers.count, 1) * len(lights))))
        size = max(1, AT_ONCE // (cells[0] * cells[1]))
        random = np.random.default_rng([SEED, index])
        for first in range(0, receivers.count, size):
            yield stratified(light, cells, receivers[first : first + size], embree, random)


def _split(segments: Segments, parts: int) -> list[Segments]:
    """In about equal parts; none of nothing."""
    rows = np.array_split(np.arange(len(segments.start)), max(parts, 1))
    return [Segments(segments.start[r], segments.rays[r], segments.t_max[r]) for r in rows if len(r)]


def those_of(segments: Segments, chosen: np.ndarray) -> Segments:
    """The `chosen` (n, k) ones, each from a start of its own."""
    row, _ = np.nonzero(chosen)
    return Segments(segments.start[row], segments.rays[chosen][:, None], segments.t_max[chosen][:, None])


def distance_to_change(embree: Occluders, segment: Segments) -> float:
    """The first of SHIFTS, in any direction, by which a ray meets another answer of Embree's; 1 beyond them."""
    ways = np.random.default_rng(SEED).normal(size=(SHIFTED, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    rays = np.repeat(segment.rays[:, 0], SHIFTED, axis=0)
    for shift in SHIFTS:
        blocked = embree.blocked_along(segment.start + shift * embree.diagonal * ways, rays, segment.t_max[0])
        if blocked.any() and not blocked.all():
            return shift
    return 1.0
