"""Frames of several techniques timed in turns, so that a machine's moods fall on all of them alike."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

from softshadows.errors import DeviceError
from softshadows.frame import Frame
from softshadows.renderer import Renderer
from softshadows.scene.lights import Light, LineLight
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique

LIGHT_STEP = 1e-6
"""Metres that the lights move from frame to frame, so that everything is redrawn: other lights to the renderer."""


@dataclass(frozen=True)
class Timing:
    """Wall times of some frames: their median, and their spread from the fastest to the slowest."""

    median_ms: float
    fastest_ms: float
    slowest_ms: float
    frames: int

    @classmethod
    def of(cls, milliseconds: Sequence[float]) -> Timing:
        """The timing of frames that took so long; at least one."""
        return cls(statistics.median(milliseconds), min(milliseconds), max(milliseconds), len(milliseconds))


@dataclass(eq=False)
class Turns:
    """Each technique's last frame, its timing, its passes' median GPU times; and in sentences which could not run."""

    frames: dict[Technique, Frame]
    times: dict[Technique, Timing]
    pass_ms: dict[Technique, dict[str, float]]
    failed: list[str]


def label_of(technique: Technique) -> str:
    """The technique's name with the options that differ from their defaults: `uniform:grid=9`."""
    changed = [
        f"{option.name}={getattr(technique, option.name)}"
        for option in technique.options()
        if getattr(technique, option.name) != option.default
    ]
    return ":".join([technique.name, *changed])


def render_in_turns(
    shot: Shot,
    techniques: Sequence[Technique],
    repeats: int,
    notice: Callable[[str, float], None],
    *,
    skip: bool = True,
    profile: str = "full",
) -> Turns:
    """Render a first frame of each technique, which compiles and uploads, then `repeats` timed ones in turns.

    The lights move a little before every frame, so that nothing is kept from the one before. Without `skip`,
    DeviceError where the adapter or the `profile` of frame.Renderer cannot do one.
    """
    frames: dict[Technique, Frame] = {}
    taken: dict[Technique, list[float]] = {}
    passes: dict[Technique, list[dict[str, float]]] = {}
    failed: list[str] = []
    lights = list(shot.scene.lights)
    with ExitStack() as stack:
        stack.callback(lambda: setattr(shot.scene, "lights", lights))
        renderers: dict[Technique, Renderer] = {}
        steps, done = (repeats + 1) * max(len(techniques), 1), 0
        for turn in range(repeats + 1):
            shot.scene.lights = [moved(light, turn * LIGHT_STEP) for light in lights]
            for technique in techniques if turn == 0 else list(renderers):
                notice(
                    f"{label_of(technique)}, " + (f"frame {turn} of {repeats}" if turn else "first frame"), done / steps
                )
                done += 1
                try:
                    if turn == 0:
                        renderers[technique] = stack.enter_context(
                            Renderer(shot.scene, technique=technique, size=shot.size, profile=profile)
                        )
                    started = time.perf_counter()
                    frames[technique] = renderers[technique].render(shot.camera)
                    if turn:
                        taken.setdefault(technique, []).append(1e3 * (time.perf_counter() - started))
                        passes.setdefault(technique, []).append(frames[technique].stats.gpu_ms)
                except DeviceError as error:
                    if not skip:
                        raise
                    for kept in (renderers, frames, taken, passes):
                        kept.pop(technique, None)
                    failed.append(f"{label_of(technique)}: {error}")
    return Turns(
        frames,
        {technique: Timing.of(each) for technique, each in taken.items()},
        {technique: _medians(each) for technique, each in passes.items()},
        failed,
    )


def _medians(frames: Sequence[dict[str, float]]) -> dict[str, float]:
    return {name: statistics.median(frame[name] for frame in frames) for name in frames[0]}


def moved(light: Light, by: float) -> Any:
    """The light a little along x."""
    if isinstance(light, LineLight):
        return replace(light, start=_along_x(light.start, by), end=_along_x(light.end, by))
    return replace(light, position=_along_x(light.position, by))  # type: ignore[attr-defined]


def _along_x(position: tuple[float, float, float], by: float) -> tuple[float, float, float]:
    return (position[0] + by, position[1], position[2])
