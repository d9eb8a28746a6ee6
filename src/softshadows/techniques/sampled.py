"""Visibility from shadow maps of points on the light: what every shadow-map technique here shares.

A technique chooses the sample points and brings a shader with an entry `cs_visibility` that looks into the maps of one
chunk of samples; this pass fits and draws the maps and runs that shader, chunk by chunk, light by light.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Bindings, Program, Resource
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext, TechniquePass
from softshadows.visibility.maps.plan import AtlasPlan, plan_atlas
from softshadows.visibility.maps.shadow_atlas import SampledLight, ShadowAtlas

Samples = tuple[np.ndarray, np.ndarray]
"""points (places × n, 2) in light space, metres, and weights (n,). Shadow maps have one place (sub_positions.py)."""


def center_sample(light: Light, jitter: int = 0) -> Samples:
    """The light's centre alone, whatever the jitter."""
    return np.zeros((1, 2)), np.ones(1)


class SampledPass(TechniquePass):
    """See the module.

    `samples_of` gives a light's samples, moved to the place with that number beside theirs (sub_positions.py).
    `lookups` counts the shadow-map reads of one pixel for a light with that many samples. A technique that
    `takes_center_only` does not ask for the light's size anywhere.
    """

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *,
        samples_of: Callable[[Light, int], Samples],
        resolution: int | str,
        lookups: Callable[[int], float],
        constants: Mapping[str, float] | None = None,
        resources: Mapping[str, Resource] | None = None,
        takes_center_only: bool = False,
        margin_texels: int = 1,
        search_margin: float = 0.0,
        keeps_maps: bool = False,
        stand_ins: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__()
        self._context, self._samples_of, self._lookups = context, samples_of, lookups
        self._takes_center_only = takes_center_only
        self._resolution, self._margin_texels = resolution, margin_texels
        self._search_margin, self._keeps_maps = search_margin, keeps_maps
        self._atlases: dict[int, ShadowAtlas] = {}  # by samples per light
        self._turns: list[tuple[ShadowAtlas, int]] = []  # per light: its atlas, and its index there
        self._shader, self._stand_ins = shader, stand_ins
        self._constants = dict(constants or {})
        self._resources = {**context.gbuffer.resources, "visibility": context.visibility, **(resources or {})}
        own = (resources or {}).values()
        self._extra_bytes = sum(resource.size for resource in own if isinstance(resource, wgpu.GPUBuffer))
        self._written: tuple[tuple[Light, ...], Geometry, int] | None = None  # what the atlases' lights were made from
        self._programs: dict[str, Program] = {}  # by entry
        self._bindings: dict[tuple[str, ShadowAtlas, int], Bindings] = {}  # by entry, atlas and chunk

    def set_lights(self, lights: Sequence[Light]) -> None:
        written = (tuple(lights), self._context.scene.geometry, self.refinements)
        if written == self._written:
            return
        self._written = written
        by_count: dict[int, list[SampledLight]] = {}
        self._turns = []
        turns: list[tuple[int, int]] = []
        for layer, light in enumerate(lights):
            points, weights = self._samples_of(light, self.refinements)
            group = by_count.setdefault(len(weights), [])
            turns.append((len(weights), len(group)))
            seen = light.without_size if self._takes_center_only else light
            group.append(SampledLight(seen, layer, points, weights))
        for count, group in by_count.items():
            if count not in self._atlases:
                self._atlases[count] = self._new_atlas(count)
            self._atlases[count].set_lights(group)
        self._turns = [(self._atlases[count], index) for count, index in turns]
        self.shadow_maps = sum(count for count, _ in turns)
        self.lookups_per_pixel = float(sum(self._lookups(count) for count, _ in turns))
        self.bytes = sum(atlas.bytes for atlas in self._atlases.values()) + self._extra_bytes

    def _plan(self, count: int) -> AtlasPlan:
        """How the maps of `count` samples are held and cut into chunks."""
        context = self._context
        size, resolution, budget = context.gbuffer.size, self._resolution, context.memory_budget
        return plan_atlas(context.gpu, context.scene, size, count, resolution, budget)

    def _new_atlas(self, count: int) -> ShadowAtlas:
        context, plan = self._context, self._plan(count)
        return ShadowAtlas(
            context.gpu,
            context.scene,
            context.gbuffer,
            plan,
            margin_texels=self._margin_texels,
            search_margin=self._search_margin,
            keeps_maps=self._keeps_maps,
        )

    def encode(self, commands: Commands) -> None:
        for atlas, index in self._turns:
            atlas.encode_receivers(commands.encoder, commands.timer, index)
            atlas.encode_fit(commands.encoder, commands.timer)
            for chunk in range(atlas.plan.chunks):
                clears_atlas = atlas.plan.starts_batch(chunk) and not atlas.keeps_maps
                atlas.encode_draw(
                    commands.encoder,
                    commands.timer,
                    chunk,
                    clears_atlas=clears_atlas,
                    clears_views=atlas.keeps_maps,
                )
                self._encode_lookups(commands, atlas, chunk)
                commands.account(self._chunk_ms(atlas))

    def _encode_lookups(self, commands: Commands, atlas: ShadowAtlas, chunk: int) -> None:
        """Turn the chunk's maps into visibility. Techniques that need steps before `cs_visibility` override this."""
        width, height = self._context.gbuffer.size
        self._dispatch(commands, atlas, chunk, "cs_visibility", "lookup", (-(-width // 8), -(-height // 8)))

    def _dispatch(
        self, commands: Commands, atlas: ShadowAtlas, chunk: int, entry: str, label: str, groups: tuple[int, int]
    ) -> None:
        """Run an entry of the technique's shader, with the bind groups that all of them share."""
        if entry not in self._programs:
            gpu, constants = self._context.gpu, self._constants
            self._programs[entry] = Program(
                gpu, self._shader, entry, self._resources, constants=constants, stand_ins=self._stand_ins
            )
        program = self._programs[entry]
        if (entry, atlas, chunk) not in self._bindings:
            self._bindings[entry, atlas, chunk] = program.bind(**self._looked_up(atlas), chunk=atlas.chunk(chunk))
        with commands.compute(label) as compute:
            program.dispatch(compute, groups, self._bindings[entry, atlas, chunk])

    def _looked_up(self, atlas: ShadowAtlas) -> Mapping[str, Resource]:
        """What the shader looks up."""
        return atlas.resources

    def _chunk_ms(self, atlas: ShadowAtlas) -> float:
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        samples = atlas.plan.samples_per_chunk
        lookups = self._lookups(atlas.plan.samples) / atlas.plan.samples * samples
        return (
            samples * self._context.scene.triangle_count / gpu.triangles_per_ms
            + width * height * lookups / gpu.lookups_per_ms
        )
