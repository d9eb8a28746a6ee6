"""A comparison: pictures × techniques, measured one after the other, kept as it goes, and written as a report.

A report is a folder: `index.html` with everything in it, `results.json` (results.py), the pictures as files, and
`cache/`, from which an interrupted comparison goes on (cache.py).

Techniques are measured one at a time, each in a renderer of its own, so that one scene at a time is on the GPU and a
finished measurement stands whatever happens afterwards. Benchmarks, which must tell small differences of time apart,
are interleaved instead (interleaved.py).
"""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from softshadows.compare.cache import CachedFrame, MeasurementCache
from softshadows.compare.interleaved import LIGHT_STEP, Timing, label_of
from softshadows.compare.measure import (
    Measurement,
    Notice,
    ReferenceFrame,
    Truth,
    able_techniques,
    reference_frame,
    trace,
)
from softshadows.compare.page import page
from softshadows.compare.plates import plates
from softshadows.compare.results import results, write_bytes, write_json
from softshadows.compare.schedule import Schedule
from softshadows.errors import DeviceError, OptionError
from softshadows.frame import Frame
from softshadows.renderer import Renderer
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique

CACHE_FOLDER = "cache"
"""Where in a report's folder its measurements are kept."""

CACHED = "cached"
"""The name of the times of frames in which nothing moves, beside "frame": everything is redrawn."""


@dataclass(frozen=True)
class Picture:
    """One shot and the techniques to measure on it. `required`: it is an error if one cannot do the shot's lights."""

    shot: Shot
    techniques: Sequence[Technique]
    required: bool = False


@dataclass(frozen=True)
class Effort:
    """How well to measure: rays per pixel and light for the truth, timed frames, and the profile of frame.Renderer."""

    samples: int = 1024
    repeats: int = 3
    profile: str = "full"


def compare(pictures: Sequence[Picture], effort: Effort, notice: Notice, kept: MeasurementCache) -> list[Measurement]:
    """Measure every technique on every picture, reusing what `kept` holds and adding to it.

    A technique that cannot do a picture is named in its `skipped`. Raises OptionError where a picture cannot be
    measured or a required technique cannot do its lights, all before the first is measured, and DeviceError where in
    the end no technique could do any picture.
    """
    able = [able_techniques(picture.shot, picture.techniques, skip=not picture.required) for picture in pictures]
    schedule = Schedule(notice)
    for picture, (techniques, _) in zip(pictures, able, strict=True):
        if kept.truth(picture.shot, effort.samples) is None:
            schedule.expect("truth")
        for technique in techniques:
            if kept.frame(picture.shot, technique, effort.repeats, effort.profile) is None:
                schedule.expect(label_of(technique))
    measured = [
        _measure(picture.shot, techniques, skipped, effort, schedule, kept)
        for picture, (techniques, skipped) in zip(pictures, able, strict=True)
    ]
    if not any(measurement.results for measurement in measured):
        raise DeviceError("nothing could be compared: " + "; ".join(s for m in measured for s in m.skipped))
    notice("writing the report", 1.0)
    return measured


def write_report(measurements: Sequence[Measurement], folder: Path) -> Path:
    """Write the report of `measurements` into `folder` and return the path of its page.

    Raises OptionError where the folder cannot be written.
    """
    data = results(measurements)
    for measurement in measurements:
        for label, pictures in plates(measurement).items():
            for caption, image in pictures:
                name = f"{file_stem(label)}-{file_stem(caption)}.png"
                write_bytes(image, folder / "images" / file_stem(measurement.shot.name) / name)
    write_json(data, folder / "results.json")
    index = folder / "index.html"
    write_bytes(page(measurements, data).encode(), index)
    return index


def file_stem(text: str) -> str:
    """`text` as part of a file name: letters, digits, dots and dashes."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", text).strip("-.") or "x"


def _measure(
    shot: Shot,
    techniques: Sequence[Technique],
    skipped: list[str],
    effort: Effort,
    schedule: Schedule,
    kept: MeasurementCache,
) -> Measurement:
    """One picture by every technique."""
    base = _held(shot, effort, schedule, kept)
    made = []
    for technique in techniques:
        label = label_of(technique)
        frame = kept.frame(shot, technique, effort.repeats, effort.profile)
        if frame is None:
            try:
                with schedule.step(label, f"{shot.name}: {label}") as within:
                    frame = _rendered(shot, technique, effort, within)
            except (DeviceError, OptionError) as refused:
                skipped.append(f"{label}: {refused}")
                continue
            kept.keep_frame(shot, technique, effort.repeats, effort.profile, frame)
        result = base.result(technique, frame, frame.times["frame"])
        result.times = dict(frame.times)
        made.append(result)
    return Measurement(shot, base.reference, made, skipped)


def _held(shot: Shot, effort: Effort, schedule: Schedule, kept: MeasurementCache) -> ReferenceFrame:
    """What the picture's frames are compared with, its truth traced only where it is not kept."""

    def tracer(shot: Shot, frame: Frame, samples: int) -> Truth:
        found = kept.truth(shot, samples)
        if found is None:
            with schedule.step("truth", f"{shot.name}: tracing the truth, {samples} rays per pixel and light"):
                found = trace(shot, frame, samples)
            kept.keep_truth(shot, samples, found)
        return found

    schedule.tell(f"{shot.name}: rendering without shadows")
    return reference_frame(shot, effort.samples, lambda doing, share: None, tracer)


def _rendered(shot: Shot, technique: Technique, effort: Effort, notice: Notice) -> CachedFrame:
    """A technique's visibility; what it costs where all is redrawn, for the lights move; and its time at rest."""
    lights = list(shot.scene.lights)
    steps = 2 * effort.repeats + 2
    taken: dict[str, list[float]] = {"frame": [], CACHED: []}
    with Renderer(shot.scene, technique=technique, size=shot.size, profile=effort.profile) as renderer:

        def render(index: int, name: str | None) -> Frame:
            notice(f"frame {index + 1} of {steps}", index / steps)
            started = time.perf_counter()
            frame = renderer.render(shot.camera)
            if name is not None:
                taken[name].append(1e3 * (time.perf_counter() - started))
            return frame

        redrawn = render(0, None)  # compiles and uploads
        try:
            for turn in range(1, effort.repeats + 1):
                shot.scene.lights = [light.moved((turn * LIGHT_STEP, 0.0, 0.0)) for light in lights]
                redrawn = render(turn, "frame")
        finally:
            shot.scene.lights = lights
        frame = render(effort.repeats + 1, None)  # the lights are back
        for turn in range(effort.repeats):
            frame = render(effort.repeats + 2 + turn, CACHED)
    times = {name: Timing.of(each) for name, each in taken.items()}
    return CachedFrame(frame.visibility, redrawn.stats, times)
