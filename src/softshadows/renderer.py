"""The story of a frame, and the first file to read.

scene, lights, camera                    plain data
  -> SceneBuffers                        uploaded once, patched when nodes move
  -> GBuffer                             what the camera sees
  -> the technique                       visibility per light
  -> Shading                             unshadowed radiance × visibility, summed over lights
  -> Frame                               read back once
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any

import numpy as np

from softshadows.errors import OptionError, SceneError
from softshadows.frame import Frame, FrameStats
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire, device_errors
from softshadows.gpu.readback import Readback
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import CAPACITY, PassTimer
from softshadows.image.accumulation import Refinement
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.passes.shading.shading import Shading
from softshadows.scene.camera import Camera
from softshadows.scene.geometry import flatten
from softshadows.scene.lights import Light
from softshadows.scene.model import Scene
from softshadows.techniques import Technique, make_technique
from softshadows.techniques.base import RenderContext


class Renderer:
    """Renders frames of one scene with one technique at one size, and keeps GPU state between them.

    Between calls `scene.lights` and the nodes' transforms may change. The profile "portable" uses only what every
    WebGPU device has: its default limits, no optional features. Raises SceneError for a scene that cannot be
    used, OptionError for an unknown technique or size, DeviceError where the adapter cannot do it.
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
        self._timer = PassTimer(self._gpu)
        self.invalidate()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.invalidate()

    def invalidate(self) -> None:
        """Forget everything on the GPU: the next frame uploads the scene and draws all again."""
        self._placement: list[tuple[int, bytes]] | None = None
        self._light_count = -1
        self._refinement = Refinement(None)

    def refine(self, camera: Camera) -> Frame:
        """The mean of a frame and all that `refine` rendered before of the same camera, lights and nodes.

        Techniques that average samples of the light, `uniform` and `adaptive`, take other samples in every frame, so
        that the mean steps toward the truth; with any other technique it stays what `render` gives.
        """
        subject = (camera, tuple(self.scene.lights), tuple(self._place_nodes()))
        if subject != self._refinement.subject:
            self._refinement = Refinement(subject)
        frame = self._render(camera, refinements=self._refinement.frames)
        frame.color, frame.visibility = self._refinement.add(frame.color, frame.visibility)
        return frame

    def render(self, camera: Camera) -> Frame:
        """One frame: encode, submit, read back once."""
        return self._render(camera, refinements=0)

    def _render(self, camera: Camera, *, refinements: int) -> Frame:
        lights = list(self.scene.lights)
        self.technique.check_lights(lights)
        with device_errors("the frame could not be rendered"):
            started = time.thread_time()
            self._upload(lights)
            self._gbuffer.set_camera(camera, len(lights))
            self._pass.refinements = refinements
            self._pass.set_lights(lights)
            self._shading.set_lights(lights)

            self._timer.begin_frame()
            commands = Commands(self._gpu, self._timer)
            self._gbuffer.encode(commands)
            if lights:
                self._pass.encode(commands)
            self._shading.encode(commands)
            self._timer.resolve(commands.encoder)
            self._readback.encode(commands.encoder)
            commands.submit()
            cpu_ms = 1e3 * (time.thread_time() - started - commands.submit_seconds)

            images = self._readback.read()
        return self._frame(images, lights, cpu_ms, commands.submits)

    def _upload(self, lights: list[Light]) -> None:
        """Bring the GPU's copy of the scene up to date."""
        placement = self._place_nodes()
        if self._placement is None or [mesh for mesh, _ in placement] != [mesh for mesh, _ in self._placement]:
            self._buffers = SceneBuffers(self._gpu, flatten(self.scene))
            self._light_count = -1
        elif placement != self._placement:
            self._buffers.move(flatten(self.scene))
        self._placement = placement
        if self._light_count != len(lights):
            self._build(len(lights))

    def _place_nodes(self) -> list[tuple[int, bytes]]:
        """Which mesh is where: node by node."""
        return [(id(node.mesh), np.asarray(node.transform, np.float64).tobytes()) for node in self.scene.nodes]

    def _build(self, light_count: int) -> None:
        """The passes and images for this many lights."""
        gpu, (width, height) = self._gpu, self.size
        visibility_bytes = 4 * max(light_count, 1) * width * height
        visibility = gpu.storage_buffer(visibility_bytes, f"the visibility of {light_count} lights")
        self._gbuffer = GBuffer(gpu, self._buffers, self.size)
        self._pass = self.technique.build(RenderContext(gpu, self._buffers, self._gbuffer, visibility))
        self._shading = Shading(gpu, self._gbuffer, visibility, light_count)
        self._readback = Readback(gpu)
        self._readback.add_texture("color", self._shading.color, "<f4", 4)
        self._readback.add_texture("position", self._gbuffer.position, "<f4", 4)
        self._readback.add_texture("normal", self._gbuffer.normal, "<f4", 4)
        self._readback.add_buffer("visibility", visibility, "<f4", (light_count, height, width))
        if self._timer.enabled:
            self._readback.add_buffer("stamps", self._timer.buffer, "<u8", (CAPACITY,))
        for name, (buffer, dtype, shape) in self._pass.results.items():
            self._readback.add_buffer(name, buffer, dtype, shape)
        self._light_count = light_count
        self._image_bytes = visibility_bytes + self._gbuffer.bytes + self._shading.bytes + self._readback.size

    def _frame(self, images: dict[str, np.ndarray], lights: list[Light], cpu_ms: float, submits: int) -> Frame:
        surface = images["position"][..., 3] > 0.0
        self._pass.take_results(images)
        stats = FrameStats(
            shadow_maps=self._pass.shadow_maps,
            lookups_per_pixel=self._pass.lookups_per_pixel,
            gpu_ms=self._timer.milliseconds(images["stamps"]) if self._timer.enabled else {},
            cpu_ms=cpu_ms,
            gpu_bytes=self._buffers.bytes + self._image_bytes + self._pass.bytes,
            submits=submits,
            warnings=[*self.scene.warnings, *self._gpu.fallbacks, *self._buffers.warnings, *self._pass.warnings],
        )
        return Frame(
            color=np.ascontiguousarray(images["color"][..., :3]),
            visibility=images["visibility"],
            position=np.ascontiguousarray(images["position"][..., :3]),
            normal=np.ascontiguousarray(images["normal"][..., :3]),
            depth=np.where(surface, images["position"][..., 3], np.float32(np.inf)),
            surface=surface,
            lights=lights,
            stats=stats,
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
