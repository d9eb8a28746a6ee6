"""Frames of several techniques, timed interleaved, so that a machine's moods fall on all of them alike."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from softshadows.errors import DeviceError
from softshadows.frame import Frame
from softshadows.renderer import Renderer
from softshadows.scene.camera import Camera
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique
from softshadows.techniques.options import as_text, changes_of

LIGHT_STEP = 1e-6
"""Metres that the lights move from frame to frame, so that everything is redrawn: other lights to the renderer."""
CAMERA_STEP = 1e-3
"""Metres that the camera moves from frame to frame where maps are cached."""
SETTLING = 2
"""Frames with a moving camera before maps are cached: the first one redraws them."""
REDRAWN, SETTLED, CACHED = "redrawn", "settled", "cached"
"""What a timed frame did: redraw all; find its maps' place; use maps that are cached."""


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
class Run:
    """A technique's first frame, then by mode the wall times of its timed frames and their GPU times by pass."""

    technique: Technique
    renderer: Renderer
    frame: Frame
    wall_ms: dict[str, list[float]] = field(default_factory=dict)
    gpu_ms: dict[str, list[dict[str, float]]] = field(default_factory=dict)

    def render(self, mode: str, camera: Camera) -> None:
        """Render a frame and note its times."""
        started = time.perf_counter()
        frame = self.renderer.render(camera)
        self.wall_ms.setdefault(mode, []).append(1e3 * (time.perf_counter() - started))
        self.gpu_ms.setdefault(mode, []).append(dict(frame.stats.gpu_ms))

    def timing(self, mode: str) -> Timing | None:
        """The median and the spread of wall times; None where the mode was not measured."""
        return Timing.of(self.wall_ms[mode]) if mode in self.wall_ms else None

    def pass_ms(self, mode: str) -> dict[str, float]:
        """Median GPU times by pass."""
        frames = self.gpu_ms.get(mode, [])
        names = dict.fromkeys(name for frame in frames for name in frame)
        return {name: statistics.median(frame.get(name, 0.0) for frame in frames) for name in names}


def label_of(technique: Technique) -> str:
    """The technique's name with the options that differ from their defaults: `uniform:grid=9`, as -t takes them."""
    return ":".join([technique.name, *(f"{name}={as_text(value)}" for name, value in changes_of(technique).items())])


def render_interleaved(
    shot: Shot,
    techniques: Sequence[Technique],
    repeats: int,
    notice: Callable[[str, float], None],
    *,
    skip: bool = True,
    profile: str = "full",
    keeps: Callable[[Technique], bool] = lambda technique: False,
    moves_scene: bool = False,
    after_first: Callable[[Run], None] = lambda run: None,
) -> tuple[list[Run], list[str]]:
    """Render a first frame of each technique, which compiles and uploads, then `repeats` timed ones, interleaved.

    The lights move a little before every frame, so that all is redrawn; with `moves_scene` so does the node with the
    most triangles. Techniques that `keeps` names are then also timed with a camera that moves and maps that are cached.
    `after_first` looks at a technique's renderer once its first frame is drawn.

    Returns the runs, and in sentences which techniques could not run; without `skip` DeviceError where the adapter or
    the `profile` of renderer.Renderer cannot do one.
    """
    runs: dict[Technique, Run] = {}
    failed: list[str] = []
    scene, lights = shot.scene, list(shot.scene.lights)
    node = max(scene.nodes, key=lambda node: len(node.mesh.triangles)) if moves_scene else None
    steps = len(techniques) * (repeats + 1) + sum(map(keeps, techniques)) * (SETTLING + repeats)
    done = 0

    def begin(technique: Technique, doing: str) -> None:
        nonlocal done
        notice(f"{label_of(technique)}, {doing}", done / max(steps, 1))
        done += 1

    with ExitStack() as stack:
        stack.callback(lambda: setattr(scene, "lights", lights))
        if node is not None:
            stack.callback(setattr, node, "transform", node.transform)

        @contextmanager
        def failing(technique: Technique) -> Iterator[None]:
            try:
                yield
            except DeviceError as error:
                if not skip:
                    raise
                runs.pop(technique, None)
                failed.append(f"{label_of(technique)}: {error}")

        for technique in techniques:
            begin(technique, "first frame")
            with failing(technique):
                renderer = stack.enter_context(Renderer(scene, technique=technique, size=shot.size, profile=profile))
                runs[technique] = Run(technique, renderer, renderer.render(shot.camera))
                after_first(runs[technique])
        for turn in range(1, repeats + 1):
            scene.lights = [light.moved((turn * LIGHT_STEP, 0.0, 0.0)) for light in lights]
            if node is not None:
                node.transform = _shift_along_x(LIGHT_STEP) @ node.transform
            for technique, run in list(runs.items()):
                begin(technique, f"frame {turn} of {repeats}")
                with failing(technique):
                    run.render(REDRAWN, shot.camera)
        for turn in range(SETTLING + repeats):
            camera = _beside(shot.camera, (turn + 1) % 2 * CAMERA_STEP)
            for technique, run in runs.items():
                if keeps(technique):
                    begin(technique, f"cached, frame {turn + 1} of {SETTLING + repeats}")
                    run.render(CACHED if turn >= SETTLING else SETTLED, camera)
    return list(runs.values()), failed


def _shift_along_x(metres: float) -> npt.NDArray[np.float64]:
    """(4, 4): a shift of the world."""
    matrix = np.eye(4)
    matrix[0, 3] = metres
    return matrix


def _beside(camera: Camera, metres: float) -> Camera:
    """The camera, shifted along its own right axis."""
    shift = metres * np.array(camera.axes[0])
    position, target = (tuple((np.array(point) + shift).tolist()) for point in (camera.position, camera.target))
    return replace(camera, position=position, target=target)
