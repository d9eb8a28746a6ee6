"""The passes of variable penumbra: map, last layer, span of depths, mask of edges, visibility."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Resource
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext
from softshadows.techniques.sampled import SampledPass, center_sample
from softshadows.visibility.maps.last_layer import LastLayer
from softshadows.visibility.maps.shadow_atlas import ShadowAtlas

COUNTERS = 128
"""Of edges.wgsl: pairs of further reads and absent pixels."""
SPAN_BYTES, SPAN_FOUND_BYTES = 16, 8
SPAN_ROWS = 8
"""Of edges.wgsl."""


class MaskedPass(SampledPass):
    """Filters what a mask of `mask_bytes` says, which an entry `cs_mask` of the shader makes from the map."""

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *,
        resolution: int | str,
        largest_lookups: int,
        constants: Mapping[str, float],
        layers: int,
        taps: wgpu.GPUBuffer,
        mask_bytes: int,
        mask_reads: int,
        takes_center_only: bool,
        margin_texels: int,
        search_margin: float,
    ) -> None:
        gpu = context.gpu
        self._mask_reads, self._layers = mask_reads, layers
        self._mask = gpu.storage_buffer(mask_bytes, "the mask of a shadow map")
        self._span = gpu.storage_buffer(SPAN_BYTES, "the span of a shadow map")
        self._counters = gpu.storage_buffer(8 * COUNTERS, "the counters of reads")
        super().__init__(
            context,
            shader,
            samples_of=center_sample,
            resolution=resolution,
            lookups=lambda _: float(largest_lookups),
            constants={**constants, "layers": layers},
            resources={"taps": taps, "mask": self._mask, "span": self._span, "counters": self._counters},
            takes_center_only=takes_center_only,
            margin_texels=margin_texels,
            search_margin=search_margin,
        )

    def _new_atlas(self, count: int) -> ShadowAtlas:
        """An atlas, with its last layer; with one layer the atlas itself stands there, unread."""
        atlas, gpu = super()._new_atlas(count), self._context.gpu
        self._last_layer = LastLayer(gpu, atlas) if self._layers == 2 else None
        self._extra_bytes += self._last_layer.bytes if self._last_layer else 0
        return atlas

    def _looked_up(self, atlas: ShadowAtlas) -> Mapping[str, Resource]:
        return {**atlas.resources, "last_layer": self._last_layer.view if self._last_layer else atlas.depth_view}

    def set_lights(self, lights: Sequence[Light]) -> None:
        super().set_lights(lights)
        solid = np.array([self._context.scene.solid_count], np.uint32)
        self._context.gpu.write(self._span, SPAN_FOUND_BYTES, solid, what="scene")

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._counters)
        super().encode(commands)

    def _encode_lookups(self, commands: Commands, atlas: ShadowAtlas, chunk: int) -> None:
        if self._last_layer:
            self._last_layer.encode(commands.encoder, commands.timer)
        commands.encoder.clear_buffer(self._mask)
        commands.encoder.clear_buffer(self._span, 0, SPAN_FOUND_BYTES)
        groups = -(-atlas.plan.atlas_size // 8)
        self._dispatch(commands, atlas, chunk, "cs_span", "span", (groups, -(-groups // SPAN_ROWS)))
        self._dispatch(commands, atlas, chunk, "cs_mask", "mask", (groups, groups))
        super()._encode_lookups(commands, atlas, chunk)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"reads": (self._counters, "<u4", (COUNTERS, 2))}

    def take_results(self, results: Mapping[str, np.ndarray]) -> None:
        """Reads of a pixel that looks into the map, summed over lights."""
        further_reads, absent_pixels = results["reads"].sum(axis=0, dtype=np.int64)
        width, height = self._context.gbuffer.size
        lights = len(self._turns)
        pixels = max(lights * width * height - int(absent_pixels), 1)
        self.lookups_per_pixel = lights * (self._mask_reads + 1.0 + float(further_reads) / pixels)
