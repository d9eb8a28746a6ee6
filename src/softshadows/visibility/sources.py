"""What makes providers: by shadow maps, by rays, or by maps with rays, as a technique's options say."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Generic, TypeVar

from softshadows.gpu.device import Gpu
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.lights.sample_sets import SampleSet
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.visibility.hybrid import MapsAndRays
from softshadows.visibility.maps.plan import AtlasPlan, plan_atlas
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps
from softshadows.visibility.provider import Provider
from softshadows.visibility.rays.light_rays import LightRays
from softshadows.visibility.rays.tree import tree_of

MadeT = TypeVar("MadeT", bound=Provider, covariant=True)


class Source(ABC, Generic[MadeT]):
    """Makes providers of one kind, for the lights of a scene that a G-buffer sees.

    `stand_ins` are for shaders that ask them; `shared_bytes` is what all of them use together.
    """

    stand_ins: Mapping[str, str] = {}
    draws_maps = True
    shared_bytes = 0

    def __init__(self, gpu: Gpu, scene: SceneBuffers, gbuffer: GBuffer) -> None:
        self.gpu, self.scene, self.gbuffer = gpu, scene, gbuffer

    @abstractmethod
    def make(self, samples: int) -> MadeT:
        """A provider for lights with so many samples."""


class MapSource(Source[ShadowMaps]):
    """Shadow maps of `resolution` texels or "auto" within `memory_budget` MiB."""

    def __init__(
        self,
        gpu: Gpu,
        scene: SceneBuffers,
        gbuffer: GBuffer,
        resolution: int | str,
        memory_budget: int,
        options: MapOptions = MapOptions(),  # noqa: B008, it is frozen
        *,
        most_per_chunk: int | None = None,
    ) -> None:
        super().__init__(gpu, scene, gbuffer)
        self._resolution, self._options = resolution, options
        self._memory_budget, self._most_per_chunk = memory_budget, most_per_chunk

    def plan(self, samples: int) -> AtlasPlan:
        """How the maps of so many samples are held, and cut into chunks."""
        size, budget = self.gbuffer.size, self._memory_budget
        return plan_atlas(self.gpu, self.scene, size, samples, self._resolution, budget, self._most_per_chunk)

    def make(self, samples: int) -> ShadowMaps:
        return ShadowMaps(self.gpu, self.scene, self.gbuffer, self.plan(samples), self._options)


class RaySource(Source[LightRays]):
    """Rays to samples that may have several `places`, by pixel (jitter.py)."""

    draws_maps = False

    def __init__(self, gpu: Gpu, scene: SceneBuffers, gbuffer: GBuffer, places: int) -> None:
        super().__init__(gpu, scene, gbuffer)
        self._places, self._tree = places, tree_of(scene)
        self.shared_bytes = self._tree.bytes
        nothing_known = {"visibility/hybrid.wgsl": "visibility/rays/unclassified.wgsl"}
        self.stand_ins = {**nothing_known, **self._tree.stand_ins}

    def make(self, samples: int) -> LightRays:
        per_chunk = min(self.gpu.budget.rays_at_once, samples)
        return LightRays(
            self._tree, self.gbuffer, SampleSet(self.gpu, samples, places=self._places, per_chunk=per_chunk)
        )


class HybridSource(Source[MapsAndRays]):
    """The maps of `maps`, and rays where they are not certain."""

    def __init__(self, maps: MapSource) -> None:
        super().__init__(maps.gpu, maps.scene, maps.gbuffer)
        self._maps, self._tree = maps, tree_of(maps.scene)
        self.stand_ins, self.shared_bytes = self._tree.stand_ins, self._tree.bytes

    def make(self, samples: int) -> MapsAndRays:
        return MapsAndRays(self._tree, self.gbuffer, self._maps.make(samples))
