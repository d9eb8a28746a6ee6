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
    """The pass. It puts the mean of visibility and colour in their place, and keeps it for the next frame."""

    def __init__(self, gpu: Gpu, visibility: GrowingBuffer, color: wgpu.GPUTexture) -> None:
        self._gpu, self._visibility, self._color = gpu, visibility, color
        self._subject: object = None
        self._takes_part = False
        self._frames = 0
        self._kept: _Kept | None = None

    @property
    def bytes(self) -> int:
        """On the GPU, once there is a mean."""
        return self._kept.bytes if self._kept is not None else 0

    def write(self, subject: object, light_count: int) -> int:
        """How many frames before this one showed the same, equal `subject`s. None: the frame stays out of the mean."""
        self._takes_part = subject is not None
        if not self._takes_part:
            return 0
        if subject != self._subject:
            self._subject, self._frames = subject, 0
        if self._kept is None:
            self._kept = _Kept(self._gpu, self._visibility, self._color)
        self._frames += 1
        self._kept.write(light_count, self._frames)
        return self._frames - 1

    def forget(self) -> None:
        """Begin again with the next frame: one was lost."""
        self._subject = None

    def encode(self, commands: Commands) -> None:
        if self._takes_part and self._kept is not None:
            self._kept.encode(commands)


class _Kept:
    """The mean so far, and what brings a frame to it."""

    def __init__(self, gpu: Gpu, visibility: GrowingBuffer, color: wgpu.GPUTexture) -> None:
        self._gpu, self._size = gpu, color.size[:2]
        self._step = gpu.storage_buffer(dtype(MeanStep).itemsize, "the step of the mean")
        self._visibility = GrowingBuffer(gpu, visibility.size, "the mean visibility")
        self._color = gpu.storage_buffer(16 * self._size[0] * self._size[1], "the mean colour")
        resources = {"step": self._step, "mean_color": self._color}
        images = {"visibility": visibility, "mean_visibility": self._visibility, "color": color}
        path = "passes/mean/mean.wgsl"
        self._average = Program(gpu, path, "cs_average", {**resources, **images})
        self._show = Program(gpu, path, "cs_show", {**resources, "shown_color": color})

    @property
    def bytes(self) -> int:
        return self._visibility.size + self._color.size

    def write(self, light_count: int, frames: int) -> None:
        self._visibility.hold(4 * light_count * self._size[0] * self._size[1])
        self._gpu.write(
            self._step, 0, pack(MeanStep(size=self._size, light_count=light_count, frames=frames)), what="samples"
        )

    def encode(self, commands: Commands) -> None:
        groups = (-(-self._size[0] // 8), -(-self._size[1] // 8))
        with commands.compute("mean") as compute:
            self._average.dispatch(compute, groups)
            self._show.dispatch(compute, groups)
