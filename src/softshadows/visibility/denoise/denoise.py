"""Visibility averaged over blocks of pixels that ask about different points of the light, without blurring shadows.

Interleaved sampling (Keller and Heidrich 2001) with a bilateral filter (Tomasi and Manduchi 1998), which alone flattens
ramps near their ends. Here two opposite pixels count alike, as the one that agrees less does: what changes evenly
across the window stays as it is. Measured: docs/decisions/0017-rays.md.
"""

from __future__ import annotations

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.program import Program
from softshadows.passes.gbuffer.gbuffer import GBuffer


class Denoise:
    """Filters every light's layer of `visibility`, whose errors are about `noise` of the light."""

    def __init__(self, gpu: Gpu, gbuffer: GBuffer, visibility: wgpu.GPUBuffer, noise: float) -> None:
        self._visibility = visibility
        self._noisy = gpu.storage_buffer(visibility.size, "the visibility before it is filtered")
        self.bytes = self._noisy.size
        width, height = gbuffer.size
        self._groups = (-(-width // 8), -(-height // 8), visibility.size // (4 * width * height))
        self._denoise = Program(
            gpu,
            "visibility/denoise/denoise.wgsl",
            "cs_denoise",
            {**gbuffer.resources, "noisy": self._noisy, "visibility": visibility},
            constants={"noise": noise},
        )

    def encode(self, commands: Commands) -> None:
        commands.encoder.copy_buffer_to_buffer(self._visibility, 0, self._noisy, 0, self._noisy.size)
        with commands.compute("denoise") as compute:
            self._denoise.dispatch(compute, self._groups)
