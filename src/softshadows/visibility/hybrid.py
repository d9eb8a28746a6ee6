"""Shadow maps where they are certain, and rays elsewhere: hybrid.wgsl."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Resource
from softshadows.lights.sample_sets import SampledLight
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.visibility.maps.shadow_maps import ShadowMaps
from softshadows.visibility.provider import Provider
from softshadows.visibility.rays.light_rays import LightRays
from softshadows.visibility.rays.tree import Bvh


class MapsAndRays(Provider):
    """Maps, and rays to the same samples."""

    def __init__(self, tree: Bvh, gbuffer: GBuffer, maps: ShadowMaps) -> None:
        self.maps, self.samples = maps, maps.samples
        self._rays = LightRays(tree, gbuffer, maps.samples)

    @property
    def bytes(self) -> int:
        return self.maps.bytes

    @property
    def can_cache(self) -> bool:
        return self.maps.can_cache

    @property
    def resources(self) -> Mapping[str, Resource]:
        return {**self._rays.resources, **self.maps.resources}

    @property
    def chunk_ms(self) -> float:
        return self.maps.chunk_ms + self._rays.chunk_ms

    def write(self, lights: Sequence[SampledLight], *, keeps_looser_fits: bool = False) -> None:
        self.maps.write(lights, keeps_looser_fits=keeps_looser_fits)

    def encode_frame(self, commands: Commands) -> None:
        self._rays.encode_frame(commands)

    def encode_selection(self, commands: Commands, index: int) -> None:
        self.maps.encode_selection(commands, index)

    def encode_chunk(self, commands: Commands, chunk: int) -> None:
        self.maps.encode_chunk(commands, chunk)
