"""Visibility averaged over blocks of pixels that ask about different points of the light, without blurring shadows.

Interleaved sampling (Keller and Heidrich 2001) with a bilateral filter (Tomasi and Manduchi 1998), which alone flattens
ramps near their ends. Here two opposite pixels count alike, as the one that agrees less does: what changes evenly
across the window stays as it is. Measured: docs/decisions/0017-rays.md.
"""

from __future__ import annotations

from collections.abc import Sequence

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.program import Program
from softshadows.lights.layers import Layers
from softshadows.passes.gbuffer.gbuffer import GBuffer


class Denoise:
    """Filters layers of `visibility` whose errors are about `noise` of the light."""

    def __init__(self, gpu: Gpu, gbuffer: GBuffer, visibility: GrowingBuffer, noise: float) -> None:
        self._visibility, self._size = visibility, gbuffer.size
        self._noisy = GrowingBuffer(gpu, visibility.size, "the visibility before it is filtered")
        self._layers = Layers(gpu)
        self._denoise = Program(
            gpu,
            "visibility/denoise/denoise.wgsl",
            "cs_denoise",
            {**gbuffer.resources, "layers": self._layers.buffer, "noisy": self._noisy, "visibility": visibility},
            constants={"noise": noise},
        )

    @property
    def bytes(self) -> int:
        """On the GPU."""
        return self._noisy.size

    def write(self, layers: Sequence[int]) -> None:
        """Which lights' visibility is filtered."""
        self._layers.write(layers)
        self._noisy.hold(self._visibility.size)

    def encode(self, commands: Commands) -> None:
        size = self._visibility.size
        commands.encoder.copy_buffer_to_buffer(self._visibility.buffer, 0, self._noisy.buffer, 0, size)
        width, height = self._size
        with commands.compute("denoise") as compute:
            self._denoise.dispatch(compute, (-(-width // 8), -(-height // 8), self._layers.count))
