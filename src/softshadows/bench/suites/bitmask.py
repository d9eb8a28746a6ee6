"""Bit-mask soft shadows against adaptive sampling, uniform rays, and Embree's rays at equal error.

Pictures: where $SOFTSHADOWS_SCENES is set real scenes under rectangle and line lights, else built-in ones. What grows
with triangles, pixels, lights and a light's size is in `scaling`.

A picture's figures:

rays                the samples, rmse and seconds of stratified rays by Embree on all cores
build_ms            its acceleration structure
receivers           pixels that face a light
bits                samples of the lights that pixels of a small picture look at, by walks and by Embree
differing           those with another answer
farthest_from_edge  see rays.py

A technique's, from frames before which the lights move, interleaved:

rmse_truth, penumbra_rmse_truth, equal_rays, equal_rays_bound, ray_time_ratio_redrawn, redrawn
                    see adaptive.py: the ratio is Embree's time for its rays alone over the whole frame's
dynamic_ratio       Embree's time to build and to cast equal_rays over a frame's before which the node with most
                    triangles has moved, too, so that both trees are made anew or fitted
moved_ms            that frame's
adaptive_ratio      the time of adaptive sampling by rays over this one's
boxes, triangles, words
                    that a pixel's walks meet, and rows of samples that they mark: means over surfaces (bitmask)
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from softshadows.bench.suites.adaptive import result_beside_rays, trace
from softshadows.bench.suites.baselines import real_shots
from softshadows.bench.suites.rays import BUILTIN, SHOTS, distance_to_change, those_of
from softshadows.compare.interleaved import REDRAWN, Run, render_interleaved
from softshadows.compare.measure import Measurement, Notice, measure_each, reference_frame
from softshadows.lights.rows import row_samples
from softshadows.renderer import Renderer
from softshadows.scene.geometry import flatten
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Adaptive, Bitmask, Technique, Uniform, make_technique
from softshadows.techniques.bitmask.bitmask import BitmaskPass
from softshadows.techniques.bitmask.pictures import look
from softshadows.truth.occluders import Occluders
from softshadows.truth.segments import Receivers, Segments, to_points

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

SIZE = (512, 384)
VIEWS = (*SHOTS, "bike_line")
ADAPTIVE = Adaptive(visibility="ray")
TECHNIQUES: tuple[Technique, ...] = (
    *(Bitmask(rows=rows) for rows in (4, 8, 16, 32)),
    make_technique("bitmask", {"preset": "preview"}),
    Bitmask(offsets="stratified", denoise=True),
    ADAPTIVE,
    Adaptive(),
    Uniform(visibility="ray", grid=9),
)
RAYS = (4, 16, 64, 144, 256, 576)
"""Per pixel: the errors of the techniques lie among theirs."""
BITS_SIZE = (128, 96)
"""The picture whose samples are compared one by one: 10⁷ of them over all shots."""


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """Bit-mask soft shadows beside adaptive sampling and rays, and as many rays by Embree as err as much."""
    return measure_each(
        views(), lambda view: view.name, lambda view, within: measure_view(view, settings, within), notice
    )


def views() -> Iterator[Shot]:
    """The scenes; SceneError where $SOFTSHADOWS_SCENES is set to a folder without any."""
    for source in list(map(str, real_shots(VIEWS))) or BUILTIN:
        yield open_shot(source)


def measure_view(view: Shot, settings: Settings, notice: Notice, bits_size: tuple[int, int] = BITS_SIZE) -> Measurement:
    """All figures of a view."""
    shot = replace(view, size=settings.size or SIZE)
    base = reference_frame(shot, settings.samples, notice)
    notice("tracing shadow rays", 0.1)
    rays = trace(shot, base, RAYS)
    started = time.perf_counter()
    Occluders(flatten(shot.scene))
    build_ms = 1e3 * (time.perf_counter() - started)

    counts: dict[Technique, dict[str, float]] = {}
    runs, skipped = render_interleaved(
        shot,
        TECHNIQUES,
        settings.repeats,
        lambda doing, share: notice(doing, 0.3 + 0.5 * share),
        after_first=lambda run: counts.update({run.technique: counts_of(run, shot)}),
    )
    moved, _ = render_interleaved(
        shot,
        [Bitmask(), ADAPTIVE],
        settings.repeats,
        lambda doing, share: notice(f"{doing}, a node moved", 0.8 + 0.2 * share),
        moves_scene=True,
    )
    moved_ms = {run.technique: timing.median_ms for run in moved if (timing := run.timing(REDRAWN))}
    adaptive_ms = {run.technique: run.timing(REDRAWN) for run in runs}.get(ADAPTIVE)
    results = [result_beside_rays(run, base, rays) for run in runs]
    receivers = int(np.count_nonzero(base.reference.mask.any(axis=0)))
    for result in results:
        figures, own_ms = result.figures, result.figures[REDRAWN]["wall_ms"]
        figures |= counts[result.technique]
        if adaptive_ms is not None:
            figures["adaptive_ratio"] = adaptive_ms.median_ms / own_ms
        if result.technique in moved_ms:
            figures["moved_ms"] = moved_ms[result.technique]
            cast_ms = figures["equal_rays"] * rays.ms_per_sample
            figures["dynamic_ratio"] = (build_ms + cast_ms) / figures["moved_ms"]
    figures = {"build_ms": build_ms, "receivers": receivers, "rays": rays.series, **bits_beside_embree(shot, bits_size)}
    return Measurement(shot, base.reference, results, skipped, figures)


def bits_beside_embree(shot: Shot, size: tuple[int, int]) -> dict[str, Any]:
    """Every sample of every light with an extent, by a walk and by a ray to the same point."""
    embree, rows = Occluders(flatten(shot.scene)), Bitmask().rows
    bits, differing = 0, []
    with Renderer(shot.scene, technique=Bitmask(), size=size) as renderer:
        frame = renderer.render(shot.camera)
        assert renderer.passes is not None
        at_work = renderer.passes.technique
        assert isinstance(at_work, BitmaskPass)
        for index, light in enumerate(shot.scene.lights):
            if not light.has_size:
                continue
            samples = row_samples(light, rows)
            points = light.center + samples.points @ light.axes[:2]
            segments = to_points(points, light, Receivers.of(frame), embree)
            visible = segments.visible(embree)
            hidden = look(at_work, light, index).hidden[frame.surface].reshape(visible.shape)
            bits += len(visible) * samples.count
            differing.append(those_of(segments, (hidden == visible) & samples.is_on_light.ravel()))
    distances = [
        distance_to_change(embree, Segments(some.start[one], some.rays[one], some.t_max[one]))
        for some in differing
        for one in np.arange(len(some.start))[:, None]
    ]
    return {"bits": bits, "differing": len(distances), "farthest_from_edge": max(distances, default=None)}


def counts_of(run: Run, shot: Shot) -> dict[str, Any]:
    """What walks meet and mark, per pixel with a surface; nothing for techniques without any."""
    assert run.renderer.passes is not None
    at_work = run.renderer.passes.technique
    if not isinstance(at_work, BitmaskPass):
        return {}
    looks = [look(at_work, light, index) for index, light in enumerate(shot.scene.lights) if light.has_size]
    return {
        name: float(sum(getattr(each, name)[run.frame.surface].mean() for each in looks))
        for name in ("boxes", "triangles", "words")
    }
