"""One shot through several techniques: each one's visibility, its time, and its distance to the truth.

Pictures are composed here for all techniques alike, unshadowed radiance per light × visibility, so that only the
visibility differs between them; their FLIP is against the picture composed with the truth.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from softshadows import metrics, truth
from softshadows.compare.interleaved import REDRAWN, Run, Timing, label_of, render_interleaved
from softshadows.errors import DeviceError, OptionError
from softshadows.frame import Frame, FrameStats
from softshadows.image.display import automatic_exposure, display
from softshadows.renderer import render
from softshadows.scene.model import Scene
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique, make_technique

Floats = npt.NDArray[np.float32]
Picture = npt.NDArray[np.uint8]
Notice = Callable[[str, float], None]
"""Called before each step with what is being done and the share of all steps that is done, 0..1."""

Step = TypeVar("Step")

MAX_MEASURED_PIXELS = 8192 * 8192
UNSHADOWED = "none"


def measure_each(
    steps: Iterable[Step],
    name_of: Callable[[Step], str],
    measure_one: Callable[[Step, Notice], Measurement],
    notice: Notice,
) -> list[Measurement]:
    """A measurement of each step; what it tells meanwhile reaches `notice` as a named part of the whole."""
    chosen = list(steps)

    def notice_within(index: int) -> Notice:
        name = name_of(chosen[index])
        return lambda doing, share: notice(f"{name}: {doing}", (index + share) / len(chosen))

    measurements = []
    for index, step in enumerate(chosen):
        within = notice_within(index)
        within("opening", 0.0)
        measurements.append(measure_one(step, within))
    return measurements


class Shadows(Protocol):
    """What is measured of a frame: a Frame, or what was kept of one."""

    @property
    def visibility(self) -> Floats: ...
    @property
    def stats(self) -> FrameStats: ...


@dataclass(frozen=True, eq=False)
class Truth:
    """Traced visibility (lights, height, width) float32, its mean standard error where metrics apply, and its time."""

    visibility: Floats
    standard_error: float
    seconds: float


Tracer = Callable[[Shot, Frame, int], Truth]
"""Finds a shot's truth at the pixels of a frame, with so many rays per pixel and light."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What every technique is measured against.

    visibility (lights, height, width) float32 by `samples` rays per pixel, with their mean standard error; mask
    (lights, height, width) bool, where metrics apply; picture (height, width, 3) uint8 sRGB, at `exposure` stops.
    """

    visibility: Floats
    mask: npt.NDArray[np.bool_]
    picture: Picture
    exposure: float
    samples: int
    standard_error: float
    seconds: float


@dataclass(eq=False)
class Result:
    """A technique on the shot.

    `times` are wall times of frames with their read-back by what was asked of them, "frame" among them: the one that
    tables show. `figures` are what a suite measures beyond that, by name: numbers, None or dicts of them.
    """

    technique: Technique
    label: str
    visibility: Floats
    picture: Picture
    comparisons: list[metrics.Comparison]
    flip: float | None
    times: dict[str, Timing]
    stats: dict[str, Any]
    warnings: list[str] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)

    @property
    def frame_ms(self) -> float:
        return self.times["frame"].median_ms


@dataclass(frozen=True, eq=False)
class Measurement:
    """A shot, its reference, and what each technique made of it; `skipped` says in sentences which could not run.

    `figures` are what a suite measures of the shot itself.
    """

    shot: Shot
    reference: Reference
    results: list[Result]
    skipped: list[str] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ReferenceFrame:
    """What the frames of one shot are compared with: its truth, and its light without shadows.

    emitted (height, width, 3) and unshadowed (lights, height, width, 3) float32 linear radiance; `frame` is unshadowed.
    """

    reference: Reference
    emitted: Floats
    unshadowed: Floats
    frame: Frame

    def result(self, technique: Technique, frame: Shadows, timing: Timing) -> Result:
        """The figures of a technique's frame."""
        reference = self.reference
        picture = display(_lit(self.emitted, self.unshadowed, frame.visibility), exposure=reference.exposure)
        comparisons = [
            metrics.compare(*light)
            for light in zip(frame.visibility, reference.visibility, reference.mask, strict=True)
        ]
        return Result(
            technique=technique,
            label=label_of(technique),
            visibility=frame.visibility,
            picture=picture,
            comparisons=comparisons,
            flip=_flip(picture, reference.picture),
            times={"frame": timing},
            stats=_stats(frame),
            warnings=list(frame.stats.warnings),
        )

    def result_of(self, run: Run) -> Result:
        """The figures of a run whose frames were redrawn."""
        timing = run.timing(REDRAWN)
        assert timing is not None, "every technique is timed with all redrawn"
        return self.result(run.technique, run.frame, timing)


def trace(shot: Shot, frame: Frame, samples: int) -> Truth:
    """The truth by Embree."""
    started = time.perf_counter()
    visibility, error = truth.visibility(shot.scene, frame, samples=samples, return_error=True)
    mask = frame.facing & frame.surface
    return Truth(visibility, float(error[mask].mean()) if mask.any() else 0.0, time.perf_counter() - started)


def reference_frame(shot: Shot, samples: int, notice: Notice, tracer: Tracer = trace) -> ReferenceFrame:
    """Render the shot without shadows, and find its truth with `samples` rays per pixel and light."""
    notice("rendering without shadows", 0.0)
    emitted, unshadowed, frame = _unshadowed(shot)
    notice(f"tracing the truth, {samples} rays per pixel and light", 0.05)
    traced = tracer(shot, frame, samples)
    radiance = _lit(emitted, unshadowed, traced.visibility)
    exposure = automatic_exposure(radiance)
    reference = Reference(
        visibility=traced.visibility,
        mask=frame.facing & frame.surface,
        picture=display(radiance, exposure=exposure),
        exposure=exposure,
        samples=samples,
        standard_error=traced.standard_error,
        seconds=traced.seconds,
    )
    return ReferenceFrame(reference, emitted, unshadowed, frame)


def measure(
    shot: Shot,
    techniques: Sequence[Technique],
    *,
    samples: int = 1024,
    repeats: int = 3,
    notice: Notice = lambda doing, share: None,
    skip: bool = False,
    profile: str = "full",
) -> Measurement:
    """Render `shot` with every technique and compare each with ray-traced truth of `samples` rays per pixel and light.

    `repeats` frames of each are timed, all redrawn, interleaved so that a machine's moods fall on all alike. Raises
    OptionError where a technique cannot do the shot's lights and DeviceError where the adapter, or the `profile` of
    renderer.Renderer, cannot; with `skip` they are left out.
    """
    able, skipped = able_techniques(shot, techniques, skip=skip)
    base = reference_frame(shot, samples, notice)
    runs, failed = render_interleaved(
        shot, able, repeats, lambda doing, share: notice(doing, 0.25 + 0.7 * share), skip=skip, profile=profile
    )

    notice("comparing", 0.95)
    results = [base.result_of(run) for run in runs]
    notice("done", 1.0)
    return Measurement(shot, base.reference, results, skipped + failed)


def able_techniques(shot: Shot, techniques: Sequence[Technique], *, skip: bool) -> tuple[list[Technique], list[str]]:
    """Those that can do the shot's lights, each once; with `skip` also a sentence on each of the others.

    Raises OptionError for a shot that cannot be measured, and without `skip` for a technique that cannot do it.
    """
    if not techniques:
        raise OptionError("nothing to compare: name at least one technique")
    if not shot.scene.lights:
        raise OptionError("nothing to compare: the scene has no light")
    if shot.size[0] * shot.size[1] > MAX_MEASURED_PIXELS:
        raise OptionError(f"comparing needs at most {MAX_MEASURED_PIXELS} pixels, got {shot.size[0]}×{shot.size[1]}")
    able: list[Technique] = []
    skipped: list[str] = []
    for technique in dict.fromkeys(techniques):
        try:
            technique.check_lights(shot.scene.lights)
            able.append(technique)
        except OptionError as error:
            if not skip:
                raise
            skipped.append(str(error))
    return able, skipped


def _unshadowed(shot: Shot) -> tuple[Floats, Floats, Frame]:
    """Emitted radiance (h, w, 3), unshadowed radiance of each light (lights, h, w, 3), and a frame with all lights."""
    scene, technique = shot.scene, make_technique(UNSHADOWED)

    def lit_by(lights: list) -> Frame:
        alone = Scene(scene.nodes, lights, scene.camera)
        return render(alone, shot.camera, technique=technique, size=shot.size)

    emitted = lit_by([]).color
    single = [lit_by([light]) for light in scene.lights]
    frame = single[0] if len(single) == 1 else lit_by(scene.lights)
    return emitted, np.stack([one.color - emitted for one in single]), frame


def _lit(emitted: Floats, unshadowed: Floats, visibility: Floats) -> Floats:
    """(h, w, 3) linear radiance: what each light would give alone × what is visible of it, and what glows by itself."""
    return emitted + np.einsum("lyxc,lyx->yxc", unshadowed, visibility)


def _stats(frame: Shadows) -> dict[str, Any]:
    stats = frame.stats
    return {
        "shadow_maps": stats.shadow_maps,
        "lookups_per_pixel": stats.lookups_per_pixel,
        "gpu_ms": dict(stats.gpu_ms),
        "cpu_ms": stats.cpu_ms,
        "gpu_bytes": stats.gpu_bytes,
    }


def _flip(picture: Picture, reference: Picture) -> float | None:
    """FLIP of two pictures; None where its evaluator is not installed."""
    try:
        return metrics.flip(picture / np.float32(255.0), reference / np.float32(255.0)).mean
    except DeviceError:
        return None
