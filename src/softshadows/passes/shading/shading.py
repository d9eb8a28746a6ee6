"""The shading pass: linear radiance of every pixel, from the G-buffer, the lights and their visibility."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import Program
from softshadows.lights import record
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.lights import Light


class Shading:
    """The pass and its image `color`: rgba32float, linear radiance, alpha 1 on surfaces and 0 elsewhere."""

    def __init__(self, gpu: Gpu, gbuffer: GBuffer, visibility: wgpu.GPUBuffer, light_count: int) -> None:
        device, usage = gpu.device, wgpu.TextureUsage
        self._gpu, self._groups = gpu, (-(-gbuffer.size[0] // 8), -(-gbuffer.size[1] // 8))
        self.color = device.create_texture(
            size=(*gbuffer.size, 1), format="rgba32float", usage=usage.STORAGE_BINDING | usage.COPY_SRC
        )
        buffer = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST
        self._lights = device.create_buffer(size=max(light_count, 1) * dtype(record.Light).itemsize, usage=buffer)
        tables = [self._table(table) for table in record.specular_tables()]
        self.bytes = 16 * gbuffer.size[0] * gbuffer.size[1] + self._lights.size

        self._shade = Program(
            gpu,
            "passes/shading/shading.wgsl",
            "cs_shade",
            {
                **gbuffer.resources,
                "g_material": gbuffer.material_view,
                "lights": self._lights,
                "visibility": visibility,
                "ltc_matrix": tables[0].create_view(),
                "ltc_albedo": tables[1].create_view(),
                "color": self.color.create_view(),
            },
        )

    def _table(self, table: np.ndarray) -> wgpu.GPUTexture:
        height, width, channels = table.shape
        texture = self._gpu.device.create_texture(
            size=(width, height, 1),
            format={2: "rg32float", 4: "rgba32float"}[channels],
            usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
        )
        layout = {"bytes_per_row": 4 * channels * width, "rows_per_image": height}
        self._gpu.device.queue.write_texture({"texture": texture}, table, layout, texture.size)
        return texture

    def set_lights(self, lights: Sequence[Light]) -> None:
        """Write the lights, as many as the pass was made for."""
        if lights:
            records = pack(*(record.light_record(light, index) for index, light in enumerate(lights)))
            self._gpu.device.queue.write_buffer(self._lights, 0, records)

    def encode(self, commands: Commands) -> None:
        with commands.compute("shading") as compute:
            self._shade.dispatch(compute, self._groups)
