"""The shading pass: linear radiance of every pixel, from the G-buffer, the lights and their visibility."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import Program, Resource
from softshadows.lights import record
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.lights import Light

COUNT_BYTES = 16
"""Before the lights: their number, up to where a record may begin."""


class Shading:
    """The pass and its image `color`: rgba32float, linear radiance, alpha 1 on surfaces and 0 elsewhere."""

    def __init__(self, gpu: Gpu, gbuffer: GBuffer, visibility: Resource) -> None:
        self._gpu, self._groups = gpu, (-(-gbuffer.size[0] // 8), -(-gbuffer.size[1] // 8))
        usage = wgpu.TextureUsage.STORAGE_BINDING | wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_SRC
        self.color = gpu.texture(gbuffer.size, "rgba32float", usage, "the colour")
        self._lights = GrowingBuffer(gpu, COUNT_BYTES + dtype(record.Light).itemsize, "the lights")
        tables = [self._table(table) for table in record.specular_tables()]
        self._image_bytes = 16 * gbuffer.size[0] * gbuffer.size[1]

        self._shade = Program(
            gpu,
            "passes/shading/shading.wgsl",
            "cs_shade",
            {
                **gbuffer.resources,
                "g_material": gbuffer.material_view,
                "lights": self._lights,
                "visibility": visibility,
                "ltc_matrix": tables[0],
                "ltc_albedo": tables[1],
                "color": self.color,
            },
        )

    def _table(self, table: np.ndarray) -> wgpu.GPUTexture:
        height, width, channels = table.shape
        usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
        format = {2: "rg32float", 4: "rgba32float"}[channels]
        texture = self._gpu.texture((width, height), format, usage, "a table of specular light")
        self._gpu.write_texture(texture, 0, table)
        return texture

    @property
    def bytes(self) -> int:
        """On the GPU."""
        return self._image_bytes + self._lights.size

    def write(self, lights: Sequence[Light]) -> None:
        """Write the lights."""
        records = pack(*(record.light_record(light, index) for index, light in enumerate(lights))) if lights else b""
        data = len(lights).to_bytes(COUNT_BYTES, "little") + records
        self._lights.hold(len(data))
        self._gpu.write(self._lights.buffer, 0, data, what="light")

    def encode(self, commands: Commands) -> None:
        with commands.compute("shading") as compute:
            self._shade.dispatch(compute, self._groups)
