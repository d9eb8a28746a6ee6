"""Adaptive sampling at work on the GPU, for lights of one shape: all levels of the tree, waiting for none of them.

    begin.wgsl     every tile of 8×8 pixels starts with the tree's root
    then level by level
      list.wgsl    the samples that some tile requests, and their share of the atlas
      fit.wgsl     their maps' windows, around the receivers in the tiles that request them
      lookup.wgsl  each map looked up once per pixel, whose answer is a bit (batch by batch, after its draw)
      trace.wgsl   or rays traced, where there are no maps or they are not certain
      compare.wgsl the paper's test of neighbouring maps, in the camera's image
      refine.wgsl  cells that failed are refined, and request the next level's samples
    bracket.wgsl   on a line, rays find the edges between samples
    average.wgsl   the bits, weighted, are the visibility; or
    filter.wgsl    the maps looked up once more, with a filter, where the bits say that it matters

A level's maps are drawn in at most so many draws as `plan.py` says, since the CPU does not know how many there will be:
where a level requests few samples, the later draws and look-ups are empty.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.program import Bindings, Program, Resource, declared
from softshadows.lights.jitter import placed, strata_of
from softshadows.lights.lattice import Lattice
from softshadows.lights.sample_sets import SampledLight, SampleSet
from softshadows.scene.lights import Light
from softshadows.techniques.adaptive.structs import Step, TreeShape
from softshadows.techniques.adaptive.tree_buffers import TreeBuffers, tiles_of
from softshadows.techniques.base import RenderContext
from softshadows.visibility.maps.plan import AtlasPlan
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps
from softshadows.visibility.rays.tree import tree_of
from softshadows.visibility.receivers import ReceiverBoxes

_FOLDER = "techniques/adaptive"
SURE_LEVELS = 3
"""Measured: docs/decisions/0010-adaptive.md."""
FINENESS = (1.0, 1.0, 0.85, 0.7, 0.5)
"""By level: how many texels along a pixel its maps have, over the first level's. Deep levels are asked for where
shadows are wide, and count little each. Measured: docs/decisions/0010-adaptive.md."""
REPORT_WORDS = 1 + constant(f"{_FOLDER}/tree.wgsl", "CUT_SHORT")
REFINE_INVOCATIONS = constant(f"{_FOLDER}/refine.wgsl", "INVOCATIONS")
TRACING = ("probe", "trace", "bracket")
"""Programs that walk the tree of the scene's triangles."""
STEPPED = ("list", "fit", "lookup", "compare", "refine")
"""Programs that run once for every batch of a level's maps, or once a level."""


@dataclass(frozen=True)
class SamplingOptions:
    """What the technique's options mean for the kernels."""

    is_global: bool
    threshold: int
    comparison_step: int
    paper_weights: bool
    pcf: int
    filters_cells: bool
    visibility: str
    offsets: str

    @property
    def is_filtered(self) -> bool:
        """Are the maps looked up a second time, with a filter, once the tree is known?"""
        return self.pcf > 0 or self.filters_cells


class AdaptiveSampling:
    """The state and the passes for lights with one lattice; one light at a time."""

    def __init__(
        self,
        context: RenderContext,
        lattice: Lattice,
        plan: AtlasPlan | None,
        batches: list[int],
        options: SamplingOptions,
        report: wgpu.GPUBuffer,
    ) -> None:
        self._context, self._lattice, self._plan = context, lattice, plan
        self._batches, self._options = batches, options
        self._tree = tree_of(context.scene) if options.visibility != "map" else None
        is_bracketed = lattice.dimensions == 1 and not options.paper_weights
        self._has_brackets = options.visibility != "map" and is_bracketed
        self._has_probes = options.visibility == "ray" and not options.is_global
        gpu, scene, gbuffer = context.gpu, context.scene, context.gbuffer
        self._maps: ShadowMaps | None = None
        if plan is not None:
            self._maps = ShadowMaps(gpu, scene, gbuffer, plan, MapOptions(caches=True))
            self._samples, self._receivers = self._maps.samples, self._maps.receivers
        else:
            self._samples = SampleSet(gpu, lattice.samples, places=strata_of(options.offsets))
            self._receivers = ReceiverBoxes(gpu, scene, gbuffer, self._samples.light)
        self._tiles = tiles_of(context.gbuffer.size)
        mask_sets = 2 if options.visibility == "hybrid" else 1  # what is visible, and what maps are not certain about
        self.buffers = TreeBuffers(context.gpu, lattice, self._shape(), mask_sets)
        self._own_bytes = self.buffers.bytes
        self._programs = self._make_programs(report)
        self._levels = [self._make_level(level) for level in range(lattice.depth + 1)]

    @property
    def lattice(self) -> Lattice:
        """How far the lights' points are moved, by number."""
        return self._lattice

    @property
    def is_global(self) -> bool:
        """Does the whole picture share one tree?"""
        return self._options.is_global

    def _shape(self) -> TreeShape:
        lattice, options, plan = self._lattice, self._options, self._plan
        return TreeShape(
            image_size=self._context.gbuffer.size,
            deepest=lattice.depth,
            has_columns=int(lattice.has_columns),
            has_rows=int(lattice.has_rows),
            columns=lattice.columns,
            sample_rows=lattice.rows,
            sample_count=lattice.samples,
            refined_rows=(1 << lattice.depth) - 1 if lattice.has_rows else lattice.depth,
            is_global=int(options.is_global),
            sure_levels=0 if options.is_global else SURE_LEVELS,
            threshold=options.threshold,
            comparison_step=options.comparison_step,
            is_resident=int(plan is None or plan.holds_all),
            largest_tile=plan.tile if plan is not None else 0,
            atlas_size=plan.atlas_size if plan is not None else 0,
            has_probes=int(self._has_probes),
            has_brackets=int(self._has_brackets),
        )

    def _make_programs(self, report: wgpu.GPUBuffer) -> dict[str, Program]:
        """By file: those that the options ask for, in the order in which they run."""
        options, has_rays = self._options, self._tree is not None
        resources: dict[str, Resource] = {
            **self._context.gbuffer.resources,
            **self._samples.resources,
            **self._receivers.resources,
            **({**self._maps.resources, **self._maps.fit_resources} if self._maps is not None else {}),
            **(self._tree.resources if self._tree is not None else {}),
            **self.buffers.resources,
            "report": report,
            "visibility": self._context.visibility,
        }
        programs: dict[str, Program] = {}

        def add(name: str, **constants: float) -> None:
            path = f"{_FOLDER}/{name}.wgsl"
            stand_ins = self._tree.stand_ins if self._tree is not None and name in TRACING else None
            used = declared(path, resources, stand_ins)
            programs[name] = Program(
                self._context.gpu, path, f"cs_{name}", used, constants=constants, stand_ins=stand_ins
            )

        add("begin")
        add("list")
        if self._has_probes:
            add("probe")
        if self._maps is not None:
            add("fit")
            add("lookup", leaves_unknown=has_rays)
        if has_rays:
            add("trace", follows_maps=self._maps is not None)
        add("compare")
        add("refine")
        if self._has_brackets:
            add("bracket")
        if options.is_filtered:
            add("filter", paper_weights=options.paper_weights, pcf_texels=options.pcf)
        else:
            add("average", paper_weights=options.paper_weights)
        return programs

    def _step(self, level: int) -> Step:
        """A level's first one."""
        lattice, at_once = self._lattice, self._context.gpu.budget.rays_at_once
        return Step(
            level=level,
            samples=_every(lattice.spacing(level), lattice.columns),
            older_samples=_every(lattice.spacing(level - 1), lattice.columns) if level else 0,
            samples_per_batch=-(-lattice.count(level) // self._batches[level]),
            first_chunk=sum(self._batches[:level]),
            first_rank=0,
            first_ray=0,
            rays=at_once,
            fineness=FINENESS[level],
        )

    def _make_level(self, level: int) -> dict[str, list[Bindings]]:
        """By program: bound to each of the level's batches of maps, or to the rays that it traces at one time."""
        first, at_once = self._step(level), self._context.gpu.budget.rays_at_once
        ranks = [batch * first.samples_per_batch for batch in range(self._batches[level])]
        batches = [self._uniform(replace(first, first_rank=rank)) for rank in ranks]
        level_of = {name: batches for name in STEPPED}
        if self._tree is not None:
            rays = range(0, self._lattice.count(level), at_once)
            level_of["trace"] = [self._uniform(replace(first, first_ray=ray)) for ray in rays]
        return {
            name: [self._programs[name].bind(step=step) for step in steps]
            for name, steps in level_of.items()
            if name in self._programs
        }

    def _uniform(self, step: Step) -> wgpu.GPUBuffer:
        buffer = self._context.gpu.uniform(step)
        self._own_bytes += buffer.size
        return buffer

    @property
    def bytes(self) -> int:
        shared = self._maps.bytes if self._maps is not None else self._samples.bytes + self._receivers.bytes
        return self._own_bytes + shared

    @property
    def can_cache(self) -> bool:
        """Can maps stay from frame to frame, where one light has them to itself?"""
        return self._plan is not None and self._plan.holds_all

    def write(self, lights: list[tuple[Light, int]], jitter: int, *, keeps_looser_fits: bool) -> None:
        """Write this frame's lights, each with its layer of visibility."""
        weights = np.ones(self._lattice.samples)
        sampled = [SampledLight(light, layer, self._points(light, jitter), weights) for light, layer in lights]
        if self._maps is not None:
            self._maps.write(sampled, keeps_looser_fits=keeps_looser_fits)
        else:
            self._samples.write(sampled)

    def _points(self, light: Light, jitter: int) -> np.ndarray:
        points_at = partial(self._lattice.points, light, is_sheared=self._tree is not None)
        return placed(points_at, jitter, self._options.offsets)

    def encode(self, commands: Commands, index: int) -> None:
        """Find light `index`'s visibility."""
        if self._tree is not None:
            self._tree.encode(commands)
        self.buffers.clear(commands.encoder)
        if self._maps is not None:
            self._maps.encode_receivers(commands, index)
        else:
            self._samples.encode(commands.encoder, index)
            self._receivers.encode(commands)
        with commands.compute("compare") as compute:
            self._programs["begin"].dispatch(compute, self._tiles)
        for level in range(self._lattice.depth + 1):
            self._encode_level(commands, level)
        if self._has_brackets:
            with commands.compute("trace") as compute:
                self._programs["bracket"].dispatch(compute, self._tiles)
        last = "filter" if self._options.is_filtered else "average"
        with commands.compute(last) as compute:
            self._programs[last].dispatch(compute, self._tiles)

    def _encode_level(self, commands: Commands, level: int) -> None:
        programs, bound, dispatches = self._programs, self._levels[level], self.buffers.dispatches
        tiles = self.buffers.tile_dispatch(level)
        with commands.compute("fit" if self._maps is not None else "trace") as compute:
            programs["list"].dispatch(compute, (1,), bound["list"][0])
            if self._maps is not None:
                samples = self.buffers.sample_dispatch(level)
                programs["fit"].dispatch_indirect(compute, dispatches, samples, bound["fit"][0])
        if level == 0 and self._has_probes:
            with commands.compute("trace") as compute:
                programs["probe"].dispatch_indirect(compute, dispatches, tiles)
        if self._maps is not None:
            self._encode_maps(commands, self._maps, level)
        for rays in bound.get("trace", ()):
            with commands.compute("trace") as compute:
                programs["trace"].dispatch_indirect(compute, dispatches, tiles, rays)
            commands.account(self._rays_ms)
        if self._lattice.dimensions == 0:
            return
        with commands.compute("compare") as compute:
            programs["compare"].dispatch_indirect(compute, dispatches, tiles, bound["compare"][0])
            if level < self._lattice.depth:
                groups = -(-self._tiles[0] * self._tiles[1] // REFINE_INVOCATIONS)
                programs["refine"].dispatch(compute, (groups,), bound["refine"][0])

    def _encode_maps(self, commands: Commands, maps: ShadowMaps, level: int) -> None:
        """Draw the level's maps, and look each up once per pixel, batch by batch."""
        first_chunk, tiles = sum(self._batches[:level]), self.buffers.tile_dispatch(level)
        for batch, step in enumerate(self._levels[level]["lookup"]):
            maps.encode_draw(commands, first_chunk + batch)
            with commands.compute("lookup") as compute:
                self._programs["lookup"].dispatch_indirect(compute, self.buffers.dispatches, tiles, step)
            commands.account(self._batch_ms(level))

    def _batch_ms(self, level: int) -> float:
        """What one of the level's batches of maps takes at most."""
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        samples = self._lattice.count(level) / self._batches[level]
        return samples * (
            self._context.scene.triangle_count / gpu.budget.triangles_per_ms
            + width * height / gpu.budget.lookups_per_ms
        )

    @property
    def _rays_ms(self) -> float:
        """What one dispatch of rays takes at most."""
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        return gpu.budget.rays_at_once * width * height / gpu.budget.rays_per_ms


def _every(spacing: int, columns: int) -> int:
    """The bits 0, spacing, 2 × spacing ... below `columns`."""
    return sum(1 << column for column in range(0, columns, spacing))
