"""Adaptive sampling at work on the GPU, for lights of one shape: all levels of the tree, waiting for none of them.

    begin.wgsl     every tile of 8×8 pixels starts with the tree's root
    then level by level
      list.wgsl    the samples that some tile requests, and their share of the atlas
      fit.wgsl     their maps' windows, around the receivers in the tiles that request them
      lookup.wgsl  each map looked up once per pixel, and remembered as a bit (batch by batch, after its draw)
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

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.kernel import Kernel, Resource
from softshadows.gpu.layout import Struct, pack
from softshadows.lights.jitter import placed
from softshadows.lights.lattice import DEEPEST, Lattice
from softshadows.scene.lights import Light
from softshadows.techniques.adaptive.structs import Levels, Step, TreeShape
from softshadows.techniques.base import RenderContext
from softshadows.visibility.maps.plan import AtlasPlan
from softshadows.visibility.maps.shadow_atlas import BOX_EDGE, SampledLight, ShadowAtlas
from softshadows.visibility.rays.tree import tree_of

_HERE = Path(__file__).parent
_USAGE = wgpu.BufferUsage
TILE = BOX_EDGE
"""Pixels along a tile's side: a tile's receivers are those of one box that windows are fitted to."""
QUADRANTS = 4
DEEPEST_CELLS = 1 << DEEPEST
CELLS_PER_ROW = 16
SURE_LEVELS = 3
"""Measured: docs/decisions/0010-adaptive.md."""
FINENESS = (1.0, 1.0, 0.85, 0.7, 0.5)
"""By level: how many texels along a pixel its maps have, over the first level's. Deep levels are asked for where
shadows are wide, and count little each. Measured: docs/decisions/0010-adaptive.md."""
REPORT_WORDS = 6
REFINE_INVOCATIONS = 64
KERNEL_BUFFERS = {
    "begin": "requests refined active_tiles control",
    "list": "control report dispatches",
    "fit": "requests control",
    "lookup": "requests masks active_tiles control",
    "trace": "requests masks active_tiles control",
    "compare": "requests refined failures masks active_tiles control report counts",
    "probe": "active_tiles control probes",
    "refine": "requests refined failures active_tiles control counts probes",
    "bracket": "requests refined masks control",
    "average": "requests refined masks control report",
    "filter": "requests refined masks control report",
}
"""By kernel: those of the sampling's buffers that it uses, all in bind group 3."""
STEPPED_KERNELS = ("list", "fit", "lookup", "compare", "refine")
BINDINGS = {
    "shape": 0,
    "requests": 1,
    "refined": 2,
    "failures": 3,
    "masks": 4,
    "active_tiles": 5,
    "control": 6,
    "report": 7,
    "dispatches": 8,
    "counts": 9,
    "probes": 12,
}
CHANGING, VISIBILITY = 10, 11
"""Bindings of bind group 3: the step or the levels; the visibility that filter.wgsl and bracket.wgsl write."""
Changing = dict[int, wgpu.GPUBindGroup]
"""A bind group that changes from dispatch to dispatch, by its number."""


@dataclass(frozen=True)
class SamplingOptions:
    """What the technique's options mean for the kernels."""

    is_global: bool
    threshold: int
    max_maps: int
    comparison_step: int
    paper_weights: bool
    is_deferred: bool
    pcf: int
    filters_cells: bool
    bias_scale: float
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
        plan: AtlasPlan,
        batches: list[int],
        options: SamplingOptions,
        report: wgpu.GPUBuffer,
    ) -> None:
        self._context, self._lattice, self._plan = context, lattice, plan
        self._batches, self._options = batches, options
        self._uses_maps, self._tree = options.visibility != "ray", None
        self._has_probes = options.visibility == "ray" and not options.is_global
        is_bracketed = lattice.dimensions == 1 and options.max_maps >= plan.samples
        is_bracketed &= not (options.paper_weights or options.is_deferred)
        self._has_brackets = options.visibility != "map" and is_bracketed
        if options.visibility != "map":
            self._tree = tree_of(context.scene)
        self._atlas = ShadowAtlas(
            context.gpu, context.scene, context.gbuffer, plan, bias_scale=options.bias_scale, keeps_maps=True
        )
        width, height = context.gbuffer.size
        self._tiles = (-(-width // TILE), -(-height // TILE))
        self.bytes = self._atlas.bytes
        self._buffers = self._make_buffers(report)
        self._kernels = self._make_kernels()
        self._begin = self._bind("begin")
        self._filter = self._bind("filter") if options.is_filtered else {}
        self._probe = self._bind("probe") if self._has_probes else {}
        self._bracket = self._bind("bracket") if self._has_brackets else {}
        self._steps = self._make_steps()
        self._rays = self._make_rays()
        self._sums = self._make_sums()

    def _make_buffers(self, report: wgpu.GPUBuffer) -> dict[str, wgpu.GPUBuffer]:
        """By the names that the shaders give them, in the order of their bindings."""
        gpu, lattice, options = self._context.gpu, self._lattice, self._options
        tiles = self._tiles[0] * self._tiles[1]
        trees = 1 if options.is_global else tiles
        refined_rows = (1 << lattice.depth) - 1 if lattice.has_rows else lattice.depth
        masks = 2 if options.visibility == "hybrid" else 1  # what is visible, and what maps are not certain about
        shape = TreeShape(
            image_size=self._context.gbuffer.size,
            deepest=lattice.depth,
            has_columns=int(lattice.has_columns),
            has_rows=int(lattice.has_rows),
            columns=lattice.columns,
            sample_rows=lattice.rows,
            sample_count=self._plan.samples,
            refined_rows=refined_rows,
            is_global=int(options.is_global),
            sure_levels=0 if options.is_global else SURE_LEVELS,
            threshold=options.threshold,
            most_samples=options.max_maps,
            comparison_step=options.comparison_step,
            is_resident=int(self._plan.holds_all),
            largest_tile=self._plan.tile,
            atlas_size=self._plan.atlas_size,
            has_probes=int(self._has_probes),
            has_brackets=int(self._has_brackets),
        )

        def buffer(words: int, usage: int = 0) -> wgpu.GPUBuffer:
            size = 4 * max(words, 4)
            gpu.check_buffer(size, "the look-ups that adaptive sampling remembers")
            self.bytes += size
            return gpu.device.create_buffer(size=size, usage=_USAGE.STORAGE | _USAGE.COPY_DST | _USAGE.COPY_SRC | usage)

        return {
            "shape": self._uniform(shape),
            "requests": buffer(trees * lattice.rows),
            "refined": buffer(trees * refined_rows),
            "failures": buffer(trees * refined_rows * QUADRANTS + tiles),
            "masks": buffer(masks * tiles * (-(-lattice.rows // 2) + 1) * TILE * TILE),
            "active_tiles": buffer((lattice.depth + 1) * tiles),
            "control": buffer(CONTROL_WORDS),
            "report": report,
            "dispatches": buffer(8 * (lattice.depth + 1), _USAGE.INDIRECT),
            "probes": buffer(tiles * 2 * DEEPEST_CELLS if self._has_probes else 0),
            "counts": buffer(trees * refined_rows * CELLS_PER_ROW if options.threshold else 0),
        }

    def _uniform(self, value: Struct) -> wgpu.GPUBuffer:
        data = pack(value)
        self.bytes += len(data)
        return self._context.gpu.device.create_buffer_with_data(data=data, usage=_USAGE.UNIFORM)

    def _make_kernels(self) -> dict[str, Kernel]:
        """By file. Bind group 3, which changes from dispatch to dispatch, is given there (`_bind`)."""
        atlas, gbuffer = self._atlas, self._context.gbuffer
        position, normal = gbuffer.position.create_view(), gbuffer.normal.create_view()
        receivers = _numbered(gbuffer.uniforms, position, normal)

        def kernel(
            name: str,
            groups: Mapping[int, Mapping[int, Resource]],
            stand_ins: Mapping[str, str] | None = None,
            **constants: float,
        ) -> Kernel:
            file = _HERE / f"{name}.wgsl"
            return Kernel(self._context.gpu, file, f"cs_{name}", groups, constants, stand_ins)

        maps = {**_numbered(atlas.light, atlas.samples, atlas.views, atlas.depth_view), 5: atlas.settings}
        windows = _numbered(
            atlas.light,
            atlas.samples,
            atlas.boxes,
            atlas.views,
            atlas.draw_views,
            atlas.arguments,
            atlas.drawn,
            atlas.settings,
        )
        weights = float(self._options.paper_weights)
        kernels = {
            "begin": kernel("begin", {0: receivers, 2: _numbered(atlas.light, atlas.boxes)}),
            "list": kernel("list", {}),
            "fit": kernel("fit", {0: windows}),
            "compare": kernel("compare", {0: _numbered(gbuffer.uniforms, position)}),
            "refine": kernel("refine", {}),
        }
        if self._uses_maps:
            kernels["lookup"] = kernel("lookup", {0: receivers, 2: maps}, leaves_unknown=float(self._tree is not None))
        if self._tree is not None:
            groups = {0: receivers, 1: self._tree.numbered, 2: _numbered(atlas.light, atlas.samples)}
            kernels["trace"] = kernel("trace", groups, self._tree.stand_ins, follows_maps=float(self._uses_maps))
            if self._has_probes:
                kernels["probe"] = kernel("probe", {**groups, 2: {0: atlas.light}}, self._tree.stand_ins)
            if self._has_brackets:
                kernels["bracket"] = kernel("bracket", groups, self._tree.stand_ins)
        if self._options.is_filtered:
            constants = {"paper_weights": weights, "pcf_texels": self._options.pcf}
            kernels["filter"] = kernel("filter", {0: receivers, 2: maps}, **constants)
        else:
            target = _numbered(atlas.light, self._context.visibility)
            kernels["average"] = kernel("average", {0: receivers, 2: target}, paper_weights=weights)
        return kernels

    def _bind(self, kernel: str, changing: Resource | None = None) -> Changing:
        """A kernel's bind group 3: the buffers it uses, and what changes from dispatch to dispatch."""
        names = ("shape", *KERNEL_BUFFERS[kernel].split())
        own: dict[int, Resource] = {BINDINGS[name]: self._buffers[name] for name in names}
        if changing is not None:
            own[CHANGING] = changing
        if kernel in ("filter", "bracket"):
            own[VISIBILITY] = self._context.visibility
        return {3: self._kernels[kernel].bind(3, own)}

    def _step(self, level: int) -> Step:
        """A level's first one."""
        lattice, at_once = self._lattice, self._context.gpu.rays_at_once
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

    def _make_rays(self) -> list[list[Changing]]:
        """By level: the dispatches that trace its rays, some of each pixel's at a time."""
        if self._tree is None:
            return [[] for _ in self._batches]
        at_once = self._context.gpu.rays_at_once
        return [
            [
                self._bind("trace", self._uniform(replace(self._step(level), first_ray=first)))
                for first in range(0, self._lattice.count(level), at_once)
            ]
            for level in range(self._lattice.depth + 1)
        ]

    def _make_steps(self) -> list[list[dict[str, Changing]]]:
        """By level and batch of maps: the step, bound for every kernel that asks for it."""
        steps = []
        for level, batches in enumerate(self._batches):
            first = self._step(level)
            ranks = [batch * first.samples_per_batch for batch in range(batches)]
            uniforms = [self._uniform(replace(first, first_rank=rank)) for rank in ranks]
            steps.append(
                [
                    {name: self._bind(name, uniform) for name in STEPPED_KERNELS if name in self._kernels}
                    for uniform in uniforms
                ]
            )
        return steps

    def _make_sums(self) -> list[Changing]:
        """The passes of the average: one over all levels, or one for each where the evaluation is deferred."""
        if self._options.is_filtered:
            return []
        levels = self._lattice.depth + 1
        ranges = [(level, level + 1) for level in range(levels)] if self._options.is_deferred else [(0, levels)]
        return [self._bind("average", self._uniform(Levels(first=first, end=end))) for first, end in ranges]

    def set_lights(self, lights: list[tuple[Light, int]], jitter: int) -> None:
        """Write this frame's lights, each with its layer of visibility."""
        weights = np.ones(self._plan.samples)
        self._atlas.set_lights(
            [SampledLight(light, layer, self._points(light, jitter), weights) for light, layer in lights]
        )

    def _points(self, light: Light, jitter: int) -> np.ndarray:
        points_at = partial(self._lattice.points, light, is_sheared=self._tree is not None)
        return placed(points_at, jitter, self._options.offsets)

    def encode(self, commands: Commands, index: int) -> None:
        """Find light `index`'s visibility."""
        if self._tree is not None:
            self._tree.encode(commands)
        commands.encoder.clear_buffer(self._buffers["control"])
        commands.encoder.clear_buffer(self._buffers["failures"])
        commands.encoder.clear_buffer(self._buffers["counts"])
        commands.encoder.clear_buffer(self._buffers["probes"])
        self._atlas.encode_receivers(commands.encoder, commands.timer, index)
        with commands.compute("compare") as compute:
            self._kernels["begin"].begin(compute, self._begin)
            compute.dispatch_workgroups(*self._tiles)
        for level in range(self._lattice.depth + 1):
            self._encode_level(commands, level)
        if self._has_brackets:
            with commands.compute("trace") as compute:
                self._kernels["bracket"].begin(compute, self._bracket)
                compute.dispatch_workgroups(*self._tiles)
        with commands.compute("filter" if self._options.is_filtered else "average") as compute:
            if self._options.is_filtered:
                self._kernels["filter"].begin(compute, self._filter)
                compute.dispatch_workgroups(*self._tiles)
                return
            for levels in self._sums:
                self._kernels["average"].begin(compute, levels)
                compute.dispatch_workgroups(*self._tiles)

    def _encode_level(self, commands: Commands, level: int) -> None:
        kernels, dispatches, steps = self._kernels, self._buffers["dispatches"], self._steps[level]
        tiles, samples = 32 * level, 32 * level + 16  # offsets of the level's indirect dispatches
        with commands.compute("fit" if self._uses_maps else "trace") as compute:
            kernels["list"].begin(compute, steps[0]["list"])
            compute.dispatch_workgroups(1)
            if self._uses_maps:
                kernels["fit"].begin(compute, steps[0]["fit"])
                compute.dispatch_workgroups_indirect(dispatches, samples)
        if level == 0 and self._has_probes:
            with commands.compute("trace") as compute:
                kernels["probe"].begin(compute, self._probe)
                compute.dispatch_workgroups_indirect(dispatches, tiles)
        if self._uses_maps:
            for batch, step in enumerate(steps):
                chunk = sum(self._batches[:level]) + batch
                self._atlas.encode_draw(commands.encoder, commands.timer, chunk, clears_atlas=False, clears_views=True)
                with commands.compute("lookup") as compute:
                    kernels["lookup"].begin(compute, step["lookup"])
                    compute.dispatch_workgroups_indirect(dispatches, tiles)
                commands.account(self._batch_ms(level))
        for rays in self._rays[level]:
            with commands.compute("trace") as compute:
                kernels["trace"].begin(compute, rays)
                compute.dispatch_workgroups_indirect(dispatches, tiles)
            commands.account(self._rays_ms)
        if self._lattice.dimensions == 0:
            return
        with commands.compute("compare") as compute:
            kernels["compare"].begin(compute, steps[0]["compare"])
            compute.dispatch_workgroups_indirect(dispatches, tiles)
            if level < self._lattice.depth:
                kernels["refine"].begin(compute, steps[0]["refine"])
                compute.dispatch_workgroups(-(-self._tiles[0] * self._tiles[1] // REFINE_INVOCATIONS))

    def _batch_ms(self, level: int) -> float:
        """What one of the level's batches of maps takes at most."""
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        samples = self._lattice.count(level) / self._batches[level]
        return samples * (
            self._context.scene.triangle_count / gpu.triangles_per_ms + width * height / gpu.lookups_per_ms
        )

    @property
    def _rays_ms(self) -> float:
        """What one dispatch of rays takes at most."""
        gpu, (width, height) = self._context.gpu, self._context.gbuffer.size
        return gpu.rays_at_once * width * height / gpu.rays_per_ms


CONTROL_WORDS = 4 * (DEEPEST + 1) + ((1 << DEEPEST) + 1) + ((1 << DEEPEST) + 1) ** 2 + 4


def _numbered(*resources: Resource) -> dict[int, Resource]:
    return dict(enumerate(resources))


def _every(spacing: int, columns: int) -> int:
    """The bits 0, spacing, 2 × spacing ... below `columns`."""
    return sum(1 << column for column in range(0, columns, spacing))
