"""The mean of frames that show the same, each with other samples of its lights: it steps toward the truth."""

from __future__ import annotations

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.layout import U32, Struct, Vec2u, dtype, pack
from softshadows.gpu.program import Program


class MeanStep(Struct):
    """The images' size and layers, and of how many frames the mean is with the one just drawn."""

    size: Vec2u
    light_count: U32
    frames: U32


class Mean:
    """The pass. It puts the mean of visibility and colour in their place, and keeps it until the next frame.

    `frames` says how many frames there are of what the last ones showed.
    """

    def __init__(self, gpu: Gpu, visibility: GrowingBuffer, color: wgpu.GPUTexture) -> None:
        self._gpu, self._size = gpu, color.size[:2]
        self._subject: object = None
        self.frames = 0
        self._step = gpu.storage_buffer(dtype(MeanStep).itemsize, "the step of the mean")
        self._visibility = GrowingBuffer(gpu, visibility.size, "the mean visibility")
        self._color = gpu.storage_buffer(16 * self._size[0] * self._size[1], "the mean colour")
        self.bytes = self._visibility.size + self._color.size
        resources = {"step": self._step, "mean_color": self._color}
        images = {"visibility": visibility, "mean_visibility": self._visibility, "color": color}
        path = "passes/mean/mean.wgsl"
        self._average = Program(gpu, path, "cs_average", {**resources, **images})
        self._show = Program(gpu, path, "cs_show", {**resources, "shown_color": color})

    def forget(self) -> None:
        """Begin again with the next frame."""
        self._subject, self.frames = None, 0

    def write(self, subject: object, light_count: int) -> None:
        """Count the frame that shows `subject`: equal subjects, one picture."""
        if subject != self._subject:
            self._subject, self.frames = subject, 0
        self.frames += 1
        self._visibility.hold(4 * light_count * self._size[0] * self._size[1])
        step = MeanStep(size=self._size, light_count=light_count, frames=self.frames)
        self._gpu.write(self._step, 0, pack(step), what="samples")

    def encode(self, commands: Commands) -> None:
        groups = (-(-self._size[0] // 8), -(-self._size[1] // 8))
        with commands.compute("mean") as compute:
            self._average.dispatch(compute, groups)
            self._show.dispatch(compute, groups)
