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
from typing import Any

from softshadows.errors import SceneError
from softshadows.frame import Frame, FrameStats
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire, device_errors
from softshadows.gpu.shared_scene import SharedScene, open_scene
from softshadows.passes.gbuffer.gbuffer import GBuffer, checked_size
from softshadows.scene.camera import Camera
from softshadows.scene.model import Scene
from softshadows.techniques import DEFAULT, Technique, make_technique
from softshadows.techniques.base import DEFAULT_MEMORY_BUDGET, checked_budget
from softshadows.techniques.frame_passes import FramePasses, Images, Submitted


class Renderer:
    """Renders frames of one scene with one technique at one size, and keeps GPU state between them.

    Between calls `scene.lights` and the nodes' transforms may change. Renderers of one scene share its copy on the GPU
    and may work in threads of their own. The profile "portable" uses only what every WebGPU device has: its default
    limits, no optional features. `memory_budget` is how many MiB the shadow maps drawn at one time may take; more of
    them are drawn in batches, or smaller where their resolution is "auto". Raises SceneError for a scene that cannot be
    used, OptionError for an unknown technique or size, DeviceError where the adapter cannot do it.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        technique: str | Technique = DEFAULT,
        size: tuple[int, int] = (1024, 768),
        options: Mapping[str, Any] | None = None,
        profile: str = "full",
        memory_budget: int = DEFAULT_MEMORY_BUDGET,
    ) -> None:
        self.scene, self.size = scene, checked_size(size)
        self.technique = make_technique(technique, options) if isinstance(technique, str) else technique
        self.passes: FramePasses | None = None
        self._memory_budget = checked_budget(memory_budget)
        self._gpu = acquire(profile)
        self._shared: SharedScene | None = None
        self._frames = 0

    # -- Frames --------------------------------------------------------------------------------------------------------

    def render(self, camera: Camera) -> Frame:
        """One frame, read back once."""
        with self._frame(camera) as (passes, commands):
            passes.readback.encode(commands.encoder)
        return self.read()

    def refine(self, camera: Camera) -> Frame:
        """The mean of a frame and all that `refine` or `draw` made before of the same camera, lights and nodes.

        Techniques that average samples of the light, `uniform` and `adaptive`, take other samples in every frame, so
        that the mean steps toward the truth; with any other technique it stays what `render` gives.
        """
        with self._frame(camera, refines=True) as (passes, commands):
            passes.readback.encode(commands.encoder)
        return self.read()

    def draw(self, camera: Camera) -> int:
        """One frame into `images`, refined as by `refine` while nothing moves. Waits for nothing.

        Shadow maps may serve that an earlier camera's frame has fitted, less tightly than `render` would fit them.
        Returns the frame's number; `finished` tells some frames later what it cost.
        """
        with self._frame(camera, refines=True, keeps_looser_fits=True) as (passes, commands):
            passes.ring.encode(commands.encoder)
        passes.ring.start(passes.submitted)
        return self._frames

    def finished(self) -> FrameStats | None:
        """Statistics of the last frame of `draw` that is known to have finished, None while there is none.

        Raises DeviceError where the GPU gave up on one.
        """
        return self.passes.finished() if self.passes is not None else None

    @property
    def images(self) -> Images:
        """The last frame on the GPU. Ask after every frame: another size, or more lights, bring others, and those of
        before are destroyed."""
        with self._gpu.lock:
            self.prepare()
        return self._ready.images

    # -- The four steps, which may be called apart: with the device's lock where others work on it, too ---------------

    def prepare(self) -> None:
        """Bring the scene on the GPU up to date, and build what is missing."""
        self.technique.check_lights(self.scene.lights)
        if self._shared is None or self._shared.scene is not self.scene:
            self.__exit__()
            self._shared = open_scene(self._gpu, self.scene)
            self._close_scene = weakref.finalize(self, self._shared.close)  # also where nobody says goodbye
        buffers = self._shared.update()
        if self.passes is None or self.passes.gbuffer.scene is not buffers:
            self._release_passes()
            owner = self._gpu.owner()
            gbuffer = GBuffer(owner, buffers, self.size)
            self.passes = FramePasses(owner, gbuffer, lambda light: self.technique, self._memory_budget)
        self.passes.prepare(len(self.scene.lights))

    def write(self, camera: Camera, *, refines: bool = False, keeps_looser_fits: bool = False) -> None:
        """Write what the frame needs from the CPU.

        With `refines` it takes part in the mean of what shows the same; with `keeps_looser_fits` it may see shadow maps
        that were fitted for other cameras.
        """
        passes, lights = self._ready, list(self.scene.lights)
        subject = (camera, tuple(lights), passes.gbuffer.scene.geometry)
        earlier = passes.mean.write(subject if refines and self.technique.refines else None, len(lights))
        passes.gbuffer.write(camera)
        passes.groups.write(lights, earlier, keeps_looser_fits=keeps_looser_fits)
        passes.shading.write(lights)

    def encode(self, commands: Commands) -> None:
        """Encode all that fills `images`."""
        passes = self._ready
        passes.gbuffer.encode(commands)
        passes.groups.encode(commands)
        passes.shading.encode(commands)
        passes.mean.encode(commands)
        passes.timer.resolve(commands.encoder)

    def read(self) -> Frame:
        """Wait for the frame that `render` or `refine` submitted. Raises DeviceError where the GPU gave up on it."""
        return self._ready.read()

    @property
    def _ready(self) -> FramePasses:
        assert self.passes is not None, "prepare() comes first"
        return self.passes

    @contextmanager
    def _frame(self, camera: Camera, **how: bool) -> Iterator[tuple[FramePasses, Commands]]:
        """The first three steps, written as `write` takes it, and the submit; before it the caller encodes copies."""
        with self._gpu.lock, device_errors("the frame could not be rendered"):
            started = time.thread_time()
            self.prepare()
            self.write(camera, **how)
            commands = Commands(self._gpu, self._ready.timer)
            self.encode(commands)
            yield self._ready, commands
            commands.submit()
            self._frames += 1
            cpu_ms = 1e3 * (time.thread_time() - started - commands.submit_seconds)
            looser = how.get("keeps_looser_fits", False)
            self._ready.submitted = Submitted(self._frames, self.scene, commands, cpu_ms, looser_fits=looser)

    # -- What is kept between frames -----------------------------------------------------------------------------------

    def resize(self, size: tuple[int, int]) -> None:
        """Render at another size from now on. The scene stays on the GPU, and nothing is compiled."""
        self.size = checked_size(size)
        self._release_passes()

    def invalidate(self) -> None:
        """Release everything on the GPU, also for others who draw the scene: the next frame uploads and draws all."""
        self._release_passes()
        if self._shared is not None:
            self._shared.forget()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *error: object) -> None:
        """Release everything on the GPU; the scene, where nobody else draws it."""
        self._release_passes()
        if self._shared is not None:
            self._close_scene()
            self._shared = None

    def _release_passes(self) -> None:
        if self.passes is not None:
            self.passes.release()
            self.passes = None


def render(
    scene: Scene,
    camera: Camera | None = None,
    *,
    technique: str | Technique = DEFAULT,
    size: tuple[int, int] = (1024, 768),
    options: Mapping[str, Any] | None = None,
    profile: str = "full",
    memory_budget: int = DEFAULT_MEMORY_BUDGET,
) -> Frame:
    """One frame of `scene` seen by `camera` (default: the scene's own). Errors as Renderer."""
    camera = camera or scene.camera
    if camera is None:
        message = "the scene has no camera; pass one: ss.Camera(position=..., target=...)"
        raise SceneError(message, code="CAMERA_MISSING")
    with Renderer(
        scene, technique=technique, size=size, options=options, profile=profile, memory_budget=memory_budget
    ) as renderer:
        return renderer.render(camera)
