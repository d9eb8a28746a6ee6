"""The steps of variable penumbra: map, last layer, span of depths, mask of edges, visibility."""

from __future__ import annotations

from collections.abc import Mapping
from weakref import WeakKeyDictionary

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.program import Resource
from softshadows.techniques.base import RenderContext
from softshadows.techniques.light_pass import ChunkPrograms, Combination, Found
from softshadows.visibility.maps.last_layer import LastLayer
from softshadows.visibility.maps.shadow_maps import ShadowMaps

COUNTERS = constant("techniques/variable_penumbra/edges.wgsl", "COUNTERS")
"""Pairs of further reads and absent pixels."""
SPAN_ROWS = constant("techniques/variable_penumbra/edges.wgsl", "SPAN_ROWS")
SPAN_BYTES, SPAN_FOUND_BYTES = 16, 8


class Masked(Combination[ShadowMaps]):
    """Filters where a mask of `mask_bytes` says, which an entry `cs_mask` of the shader makes from the map."""

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *,
        constants: Mapping[str, float],
        layers: int,
        taps: wgpu.GPUBuffer,
        most_lookups: int,
        mask_bytes: int,
        mask_reads: int,
    ) -> None:
        super().__init__(context)
        gpu = context.gpu
        self._most_lookups, self._mask_reads, self._layers = most_lookups, mask_reads, layers
        self._mask = gpu.storage_buffer(mask_bytes, "the mask of a shadow map")
        self._span = gpu.storage_buffer(SPAN_BYTES, "the span of a shadow map")
        self._counters = gpu.storage_buffer(8 * COUNTERS, "the counters of reads")
        self._programs = ChunkPrograms(
            context,
            shader,
            "cs_span",
            "cs_mask",
            "cs_visibility",
            resources={"taps": taps, "mask": self._mask, "span": self._span, "counters": self._counters},
            constants={**constants, "layers": layers},
        )
        self._last_layers: WeakKeyDictionary[ShadowMaps, LastLayer] = WeakKeyDictionary()
        self._own_bytes = sum(buffer.size for buffer in (taps, self._mask, self._span, self._counters))

    @property
    def bytes(self) -> int:
        return self._own_bytes + sum(layer.bytes for layer in self._last_layers.values())

    def lookups(self, samples: int) -> float:
        return float(self._most_lookups)

    def encode_frame(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._counters)
        solid = np.array([self.context.scene.solid_count], np.uint32)
        self.context.gpu.write(self._span, SPAN_FOUND_BYTES, solid, what="scene")

    def encode(self, commands: Commands, provider: ShadowMaps, chunk: int) -> None:
        last_layer = self._encode_last_layer(commands, provider)
        commands.encoder.clear_buffer(self._mask)
        commands.encoder.clear_buffer(self._span, 0, SPAN_FOUND_BYTES)
        groups, run = -(-provider.plan.atlas_size // 8), self._programs.encode
        run(commands, "span", "cs_span", provider, chunk, groups=(groups, -(-groups // SPAN_ROWS)), beside=last_layer)
        run(commands, "mask", "cs_mask", provider, chunk, groups=(groups, groups), beside=last_layer)
        run(commands, "lookup", "cs_visibility", provider, chunk, beside=last_layer)

    def _encode_last_layer(self, commands: Commands, maps: ShadowMaps) -> Mapping[str, Resource]:
        """The maps' last layer; with one layer the maps themselves stand there, unread."""
        if self._layers == 1:
            return {"last_layer": maps.depth_view}
        if maps not in self._last_layers:
            self._last_layers[maps] = LastLayer(self.context.gpu, maps)
        self._last_layers[maps].encode(commands)
        return {"last_layer": self._last_layers[maps].view}

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"reads": (self._counters, "<u4", (COUNTERS, 2))}

    def read(self, results: Mapping[str, np.ndarray], lights: int) -> Found:
        """Reads of a pixel that looks into the map, summed over lights."""
        further_reads, absent_pixels = results["reads"].sum(axis=0, dtype=np.int64)
        width, height = self.context.gbuffer.size
        pixels = max(lights * width * height - int(absent_pixels), 1)
        return Found(lookups_per_pixel=lights * (self._mask_reads + 1.0 + float(further_reads) / pixels))
