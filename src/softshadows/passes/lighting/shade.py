"""The lighting pass: linear radiance of every pixel, from the G-buffer, the lights and their visibility."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import wgpu

from softshadows.gpu.compose import shader_module
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.timing import PassTimer
from softshadows.passes.gbuffer.gbuffer import FrameUniforms, GBuffer
from softshadows.passes.lighting import lighting
from softshadows.scene.lights import Light


class Lighting:
    """The pass and its image `color`: rgba32float, linear radiance, alpha 1 on surfaces and 0 elsewhere."""

    def __init__(self, gpu: Gpu, gbuffer: GBuffer, visibility: wgpu.GPUBuffer, light_count: int) -> None:
        device, usage = gpu.device, wgpu.TextureUsage
        self._gpu, self._groups = gpu, (-(-gbuffer.size[0] // 8), -(-gbuffer.size[1] // 8))
        self.color = device.create_texture(
            size=(*gbuffer.size, 1), format="rgba32float", usage=usage.STORAGE_BINDING | usage.COPY_SRC
        )
        buffer = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST
        self._lights = device.create_buffer(size=max(light_count, 1) * dtype(lighting.Light).itemsize, usage=buffer)
        tables = [self._table(table) for table in lighting.specular_tables()]
        self.bytes = 16 * gbuffer.size[0] * gbuffer.size[1] + self._lights.size

        compute, unfilterable = wgpu.ShaderStage.COMPUTE, {"sample_type": "unfilterable-float"}
        storage = {"type": "read-only-storage"}
        kinds = [
            ({"buffer": gbuffer.uniforms}, {"buffer": {"type": "uniform"}}),
            (gbuffer.position.create_view(), {"texture": unfilterable}),
            (gbuffer.normal.create_view(), {"texture": unfilterable}),
            (gbuffer.material.create_view(), {"texture": {"sample_type": "uint"}}),
            ({"buffer": self._lights}, {"buffer": storage}),
            ({"buffer": visibility}, {"buffer": storage}),
            (tables[0].create_view(), {"texture": unfilterable}),
            (tables[1].create_view(), {"texture": unfilterable}),
            (self.color.create_view(), {"storage_texture": {"access": "write-only", "format": "rgba32float"}}),
        ]
        layout = device.create_bind_group_layout(
            entries=[{"binding": i, "visibility": compute, **kind} for i, (_, kind) in enumerate(kinds)]
        )
        self._bindings = device.create_bind_group(
            layout=layout, entries=[{"binding": i, "resource": resource} for i, (resource, _) in enumerate(kinds)]
        )
        module = shader_module(device, Path(__file__).with_name("lighting.wgsl"), (FrameUniforms, lighting.Light))
        self._pipeline = device.create_compute_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=[layout]),
            compute={"module": module, "entry_point": "cs_lighting"},
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
            self._gpu.device.queue.write_buffer(self._lights, 0, pack(*map(lighting.light_record, lights)))

    def encode(self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer) -> None:
        shade = encoder.begin_compute_pass(timestamp_writes=timer.writes("lighting"))
        shade.set_pipeline(self._pipeline)
        shade.set_bind_group(0, self._bindings)
        shade.dispatch_workgroups(*self._groups)
        shade.end()
