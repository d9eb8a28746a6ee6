"""Visibility from rays to points on the light, or from shadow maps where they are certain and rays elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Resource
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext
from softshadows.techniques.sampled import SampledPass, Samples
from softshadows.visibility.denoise.denoise import Denoise
from softshadows.visibility.maps.plan import AtlasPlan, plan_atlas, plan_without_maps
from softshadows.visibility.maps.shadow_atlas import ShadowAtlas
from softshadows.visibility.rays.tree import CUT_SHORT, tree_of


class TracedPass(SampledPass):
    """A SampledPass whose shader includes light_rays.wgsl and known_by_map.wgsl, and reports at binding 1 of group 3.

    Without `uses_maps` no map is drawn, and every ray is traced; samples then may have several `places`, and visibility
    that is off by `noise` is filtered.
    """

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *,
        samples_of: Callable[[Light, int], Samples],
        resolution: int | str,
        uses_maps: bool,
        places: int,
        noise: float | None,
    ) -> None:
        self._places = places
        self._tree, self._uses_maps = tree_of(context.scene), uses_maps
        self._report = context.gpu.storage_buffer(4, "the rays' report")
        known = {} if uses_maps else {"visibility/hybrid.wgsl": "visibility/rays/known_by_nothing.wgsl"}
        super().__init__(
            context,
            shader,
            samples_of=samples_of,
            resolution=resolution,
            lookups=float,
            resources={"report": self._report, **self._tree.resources},
            keeps_maps=uses_maps,
            stand_ins={**known, **self._tree.stand_ins},
        )
        self._denoise = Denoise(context.gpu, context.gbuffer, context.visibility, noise) if noise else None
        self._extra_bytes = self._report.size + self._tree.bytes
        self._extra_bytes += self._denoise.bytes if self._denoise is not None else 0

    def _looked_up(self, atlas: ShadowAtlas) -> Mapping[str, Resource]:
        return atlas.resources if self._uses_maps else atlas.sample_resources

    def _plan(self, count: int) -> AtlasPlan:
        context = self._context
        size, resolution, budget = context.gbuffer.size, self._resolution, context.memory_budget
        if self._uses_maps:
            return plan_atlas(context.gpu, context.scene, size, count, resolution, budget, context.gpu.rays_at_once)
        return plan_without_maps(count, min(context.gpu.rays_at_once, count), self._places)

    def set_lights(self, lights: Sequence[Light]) -> None:
        super().set_lights(lights)
        if not self._uses_maps:
            self.shadow_maps = 0
        if self._denoise is not None:
            self._denoise.set_layers(range(len(lights)))

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._report)
        self._tree.encode(commands)
        if self._uses_maps:
            super().encode(commands)
            return
        for atlas, index in self._turns:
            atlas.encode_receivers(commands.encoder, commands.timer, index)
            for chunk in range(atlas.plan.chunks):
                self._encode_lookups(commands, atlas, chunk)
                commands.account(self._chunk_ms(atlas))
        if self._denoise is not None:
            self._denoise.encode(commands)

    def _encode_lookups(self, commands: Commands, atlas: ShadowAtlas, chunk: int) -> None:
        width, height = self._context.gbuffer.size
        self._dispatch(commands, atlas, chunk, "cs_trace", "trace", (-(-width // 8), -(-height // 8)))

    def _chunk_ms(self, atlas: ShadowAtlas) -> float:
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        draws = self._context.scene.triangle_count / gpu.triangles_per_ms if self._uses_maps else 0.0
        return atlas.plan.samples_per_chunk * (draws + width * height / gpu.rays_per_ms)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"report": (self._report, "<u4", (1,))}

    def take_results(self, results: Mapping[str, np.ndarray]) -> None:
        self.warnings = [CUT_SHORT] if results["report"][0] else []
