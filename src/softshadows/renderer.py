"""The story of a frame, and the first file to read.

scene, lights, camera       plain data
prepare   SharedScene       uploaded once for all who draw it, patched when nodes move
          FramePasses       images and passes, built where they are missing
write                       all that a frame needs from the CPU, in small writes
encode    GBuffer           what the camera sees
          LightGroups       visibility per light, by its technique
          Shading           unshadowed radiance × visibility, summed over lights
          Mean              of the frames that show the same, where they are refined
read      Frame             read back once; `draw` leaves the images on the GPU
"""

from __future__ import annotations

import time
import weakref
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import numpy as np

from softshadows.errors import DeviceError, OptionError, SceneError
from softshadows.frame import Frame, FrameStats
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire, device_errors
from softshadows.gpu.shared_scene import SharedScene, open_scene
from softshadows.gpu.timing import milliseconds
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.camera import Camera
from softshadows.scene.model import Scene
from softshadows.techniques import Technique, make_technique
from softshadows.techniques.base import TechniquePass
from softshadows.techniques.frame_passes import FramePasses, Images, Submitted


class Renderer:
    """Renders frames of one scene with one technique at one size, and keeps GPU state between them.

    Between calls `scene.lights` and the nodes' transforms may change. Renderers of one scene share its copy on the GPU
    and may work in threads of their own. The profile "portable" uses only what every WebGPU device has: its default
    limits, no optional features. Raises SceneError for a scene that cannot be used, OptionError for an unknown
    technique or size, DeviceError where the adapter cannot do it.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        technique: str | Technique = "uniform",
        size: tuple[int, int] = (1024, 768),
        options: Mapping[str, Any] | None = None,
        profile: str = "full",
    ) -> None:
        self.scene, self.size = scene, _checked_size(size)
        self.technique = make_technique(technique, options) if isinstance(technique, str) else technique
        self._gpu = acquire(profile)
        self._shared: SharedScene | None = None
        self._passes: FramePasses | None = None
        self._refines = False
        self._submitted = Submitted(0, [], [], 0.0, 0)
        self._finished: FrameStats | None = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release everything on the GPU; the scene, where nobody else draws it."""
        self._release()

    def _release(self) -> None:
        self._release_passes()
        if self._shared is not None:
            self._close_scene()
            self._shared = None

    def invalidate(self) -> None:
        """Release everything on the GPU, also for others who draw the scene: the next frame uploads and draws all."""
        self._release_passes()
        if self._shared is not None:
            self._shared.forget()

    def resize(self, size: tuple[int, int]) -> None:
        """Render at another size from now on. The scene stays on the GPU, and nothing is compiled."""
        self.size = _checked_size(size)
        self._release_passes()

    def _release_passes(self) -> None:
        if self._passes is not None:
            self._passes.release()
        self._passes = self._finished = None

    # -- Frames --------------------------------------------------------------------------------------------------------

    def render(self, camera: Camera) -> Frame:
        """One frame, read back once."""
        with self._submitting(camera, refines=False) as (passes, commands):
            passes.readback.encode(commands.encoder)
        return self.read()

    def refine(self, camera: Camera) -> Frame:
        """The mean of a frame and all that `refine` or `draw` made before of the same camera, lights and nodes.

        Techniques that average samples of the light, `uniform` and `adaptive`, take other samples in every frame, so
        that the mean steps toward the truth; with any other technique it stays what `render` gives.
        """
        with self._submitting(camera, refines=True) as (passes, commands):
            passes.readback.encode(commands.encoder)
        return self.read()

    def draw(self, camera: Camera) -> int:
        """One frame into `images`, refined as by `refine` while nothing moves; returns its number, and waits for
        nothing. `finished` tells later what it cost."""
        with self._submitting(camera, refines=True) as (passes, commands):
            passes.ring.encode(commands.encoder)
        passes.ring.start(self._submitted)
        return self._submitted.number

    def finished(self) -> FrameStats | None:
        """Statistics of the last frame of `draw` that is known to have finished; None while there is none.

        Raises DeviceError where the GPU gave up on one.
        """
        found = self._passes.ring.finished() if self._passes is not None else None
        if found is not None:
            self._finished = self._stats(*found)
        return self._finished

    @property
    def images(self) -> Images:
        """The last frame on the GPU. Ask again after every frame: `resize` and lights that are added replace some."""
        if self._passes is None:
            self.prepare()
        return self._prepared[0].images

    @property
    def technique_pass(self) -> TechniquePass | None:
        """The technique at work, for pictures of what it decided; None before the first frame."""
        return next(iter(self._passes.groups.passes), None) if self._passes is not None else None

    # -- The four steps, which may be called apart ---------------------------------------------------------------------

    def prepare(self) -> None:
        """Bring the scene on the GPU up to date, and build what is missing."""
        self.technique.check_lights(self.scene.lights)
        if self._shared is None or self._shared.scene is not self.scene:
            self._release()
            self._shared = open_scene(self._gpu, self.scene)
            self._close_scene = weakref.finalize(self, self._shared.close)  # also where nobody says goodbye
        buffers = self._shared.update()
        if self._passes is None or self._passes.gbuffer.scene is not buffers:
            self._release_passes()
            owner = self._gpu.owner()
            self._passes = FramePasses(owner, GBuffer(owner, buffers, self.size), lambda light: self.technique)
        self._passes.prepare(len(self.scene.lights))

    def write(self, camera: Camera, *, refines: bool = False) -> None:
        """Write what the frame needs from the CPU. With `refines` it takes part in the mean of what shows the same."""
        (passes, scene), lights = self._prepared, list(self.scene.lights)
        self._refines = refines and self.technique.refines
        if self._refines:
            passes.mean.write((camera, tuple(lights), scene.placement), len(lights))
        passes.gbuffer.set_camera(camera, len(lights))
        passes.groups.write(lights, passes.mean.frames - 1 if self._refines else 0)
        passes.shading.set_lights(lights)

    def encode(self, commands: Commands) -> None:
        """Encode all that fills `images`."""
        passes, _ = self._prepared
        passes.gbuffer.encode(commands)
        passes.groups.encode(commands)
        passes.shading.encode(commands)
        if self._refines:
            passes.mean.encode(commands)
        passes.timer.resolve(commands.encoder)

    def read(self) -> Frame:
        """Wait for the frame whose images were copied to be read when it was submitted.

        Raises DeviceError where the GPU gave up on it.
        """
        passes, _ = self._prepared
        try:
            images = passes.readback.read()
        except DeviceError:
            passes.forget_mean()
            raise
        return Frame.of(images, self._submitted.lights, self._stats(images, self._submitted))

    @property
    def _prepared(self) -> tuple[FramePasses, SharedScene]:
        assert self._passes is not None, "prepare() comes first"
        assert self._shared is not None
        return self._passes, self._shared

    @contextmanager
    def _submitting(self, camera: Camera, *, refines: bool) -> Iterator[tuple[FramePasses, Commands]]:
        """The first three steps and the submit, between which the caller encodes what is to be copied."""
        with self._gpu.lock, device_errors("the frame could not be rendered"):
            started = time.thread_time()
            self.prepare()
            self.write(camera, refines=refines)
            passes, _ = self._prepared
            commands = Commands(self._gpu, passes.timer)
            self.encode(commands)
            yield passes, commands
            commands.submit()
            self._submitted = Submitted(
                number=self._submitted.number + 1,
                lights=list(self.scene.lights),
                pass_names=list(passes.timer.names),
                cpu_ms=1e3 * (time.thread_time() - started - commands.submit_seconds),
                submits=commands.submits,
            )

    def _stats(self, results: Mapping[str, np.ndarray], submitted: Submitted) -> FrameStats:
        passes, groups = self._prepared[0], self._prepared[0].groups
        groups.take_results(results)
        return FrameStats(
            shadow_maps=groups.shadow_maps,
            lookups_per_pixel=groups.lookups_per_pixel,
            gpu_ms=milliseconds(submitted.pass_names, results["stamps"]) if passes.timer.enabled else {},
            cpu_ms=submitted.cpu_ms,
            gpu_bytes=passes.gbuffer.scene.bytes + passes.bytes,
            submits=submitted.submits,
            warnings=[*self.scene.warnings, *self._gpu.fallbacks, *passes.gbuffer.scene.warnings, *groups.warnings],
            number=submitted.number,
        )


def render(
    scene: Scene,
    camera: Camera | None = None,
    *,
    technique: str | Technique = "uniform",
    size: tuple[int, int] = (1024, 768),
    options: Mapping[str, Any] | None = None,
    profile: str = "full",
) -> Frame:
    """One frame of `scene` seen by `camera` (default: the scene's own). Errors as Renderer."""
    camera = camera or scene.camera
    if camera is None:
        raise SceneError(
            "the scene has no camera; pass one: ss.Camera(position=..., target=...)", code="CAMERA_MISSING"
        )
    with Renderer(scene, technique=technique, size=size, options=options, profile=profile) as renderer:
        return renderer.render(camera)


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = (int(extent) for extent in size)
    except (TypeError, ValueError):
        raise OptionError(f"size must be (width, height) in pixels, got {size!r}") from None
    if min(width, height) < 1:
        raise OptionError(f"size must be at least 1×1 pixels, got {size!r}")
    return width, height
