"""Rays from receivers to a light's samples: light_rays.wgsl."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Resource
from softshadows.lights.sample_sets import SampledLight, SampleSet
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.visibility.provider import Provider
from softshadows.visibility.rays.tree import Bvh


class LightRays(Provider):
    """All samples by rays."""

    def __init__(self, tree: Bvh, gbuffer: GBuffer, samples: SampleSet) -> None:
        self.tree, self.samples, self._gbuffer = tree, samples, gbuffer

    @property
    def bytes(self) -> int:
        return self.samples.bytes

    @property
    def resources(self) -> Mapping[str, Resource]:
        return {**self.samples.resources, **self.tree.resources}

    @property
    def chunk_ms(self) -> float:
        width, height = self._gbuffer.size
        return self.samples.per_chunk * width * height / self.tree.gpu.budget.rays_per_ms

    def write(self, lights: Sequence[SampledLight], *, keeps_looser_fits: bool = False) -> None:
        self.samples.write(lights)

    def encode_frame(self, commands: Commands) -> None:
        """Bring the tree up to date."""
        self.tree.encode(commands)

    def encode_selection(self, commands: Commands, index: int) -> None:
        self.samples.encode(commands.encoder, index)
