"""What draws a frame at one size, and the images that it fills."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import wgpu

from softshadows.errors import DeviceError
from softshadows.frame import Frame, FrameStats, frame_of
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.readback import Readback, StatisticsRing
from softshadows.gpu.timing import CAPACITY, PassTimer, milliseconds
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.passes.mean.mean import Mean
from softshadows.passes.shading.shading import Shading
from softshadows.scene.model import Scene
from softshadows.techniques.base import DEFAULT_MEMORY_BUDGET, RenderContext, Technique, TechniquePass
from softshadows.techniques.light_groups import LightGroups


@dataclass(frozen=True)
class Images:
    """A frame on the GPU, of the renderer's size; row 0 is the top.

    color: rgba32float, linear radiance, alpha 1 on surfaces and 0 elsewhere; visibility: array<f32>, [light][y][x], 1
    where there is no surface; position: rgba32float, world space and view depth, 0 where there is no surface; normal:
    rgba32float, geometric, facing the viewer. All may be bound: textures as such, visibility as a storage buffer.
    """

    color: wgpu.GPUTexture
    visibility: wgpu.GPUBuffer
    position: wgpu.GPUTexture
    normal: wgpu.GPUTexture


class Submitted:
    """What the CPU knows of a frame: its number, counted from 1, lights, timed passes, and what it cost."""

    def __init__(self, number: int, scene: Scene, commands: Commands, cpu_ms: float, *, looser_fits: bool) -> None:
        self.number, self.cpu_ms, self.submits = number, cpu_ms, commands.submits
        self.lights, self.warnings = list(scene.lights), list(scene.warnings)
        self.pass_names = list(commands.timer.names)
        self.looser_fits = looser_fits


class FramePasses:
    """Everything of a frame behind the G-buffer, which passes opened together for one camera and size may share.

    `technique_of` names the technique of a light by its index, `memory_budget` is RenderContext's. `prepare` is first.
    """

    def __init__(
        self,
        gpu: Gpu,
        gbuffer: GBuffer,
        technique_of: Callable[[int], Technique],
        memory_budget: int = DEFAULT_MEMORY_BUDGET,
    ) -> None:
        self._gpu, self.gbuffer, self.timer = gpu, gbuffer, PassTimer(gpu)
        self._visibility = GrowingBuffer(gpu, 4 * gbuffer.size[0] * gbuffer.size[1], "the visibility")
        self.shading = Shading(gpu, gbuffer, self._visibility)
        self.mean = Mean(gpu, self._visibility, self.shading.color)
        self.groups = LightGroups(
            RenderContext(gpu, gbuffer.scene, gbuffer, self._visibility, memory_budget), technique_of
        )
        self._reading = gpu.owner()
        self.submitted: Submitted
        self._finished: FrameStats | None = None
        self._light_count = -1

    @property
    def technique(self) -> TechniquePass:
        """The technique at work on the first light, for pictures of what it decided."""
        return self.groups.passes[0]

    @property
    def images(self) -> Images:
        """What the last frame filled; a frame with more lights may bring another visibility."""
        return Images(self.shading.color, self._visibility.buffer, self.gbuffer.position, self.gbuffer.normal)

    @property
    def bytes(self) -> int:
        """What everything but the scene takes."""
        images = self.gbuffer.bytes + self._visibility.size + self.shading.bytes + self.readback.size + self.ring.size
        return images + self.groups.bytes + self.mean.bytes

    def prepare(self, light_count: int) -> None:
        """Make room for so many lights, and build the passes that they ask for."""
        if light_count == self._light_count:
            return
        width, height = self.gbuffer.size
        self._visibility.hold(4 * light_count * width * height)
        self.groups.prepare(light_count)
        self._reading.release()
        self.readback = self._statistics()
        self.readback.add_texture("color", self.shading.color, "<f4", 4)
        self.readback.add_texture("position", self.gbuffer.position, "<f4", 4)
        self.readback.add_texture("normal", self.gbuffer.normal, "<f4", 4)
        self.readback.add_buffer("visibility", self._visibility, "<f4", (light_count, height, width))
        self.ring: StatisticsRing[Submitted] = StatisticsRing(self._statistics)
        self._light_count = light_count

    def _statistics(self) -> Readback:
        """A read-back of all that is no image."""
        readback = Readback(self._reading)
        if self.timer.enabled:
            readback.add_buffer("stamps", self.timer.buffer, "<u8", (CAPACITY,))
        for name, (buffer, dtype, shape) in self.groups.results.items():
            readback.add_buffer(name, buffer, dtype, shape)
        return readback

    def read(self) -> Frame:
        """Wait for the frame submitted last, whose images were copied. Raises DeviceError where the GPU gave up."""
        try:
            images = self.readback.read()
        except DeviceError:
            self.mean.forget()
            raise
        return frame_of(images, self.submitted.lights, self._stats(images, self.submitted))

    def finished(self) -> FrameStats | None:
        """Statistics of the last frame that has finished, of those whose statistics alone were copied."""
        try:
            found = self.ring.finished()
        except DeviceError:
            self.mean.forget()
            raise
        if found is not None:
            self._finished = self._stats(*found)
        return self._finished

    def _stats(self, results: Mapping[str, np.ndarray], submitted: Submitted) -> FrameStats:
        gpu, scene, groups = self._gpu, self.gbuffer.scene, self.groups
        groups.read(results)
        return FrameStats(
            shadow_maps=groups.shadow_maps,
            lookups_per_pixel=groups.lookups_per_pixel,
            gpu_ms=milliseconds(submitted.pass_names, results["stamps"]) if self.timer.enabled else {},
            cpu_ms=submitted.cpu_ms,
            gpu_bytes=scene.bytes + self.bytes,
            submits=submitted.submits,
            warnings=[*submitted.warnings, *gpu.fallbacks, *scene.warnings, *groups.warnings],
            number=submitted.number,
            looser_fits=submitted.looser_fits,
        )

    def release(self) -> None:
        """Destroy all that was made through the same owner, and what is read back."""
        self._reading.release()
        self._gpu.release()
