"""Occluding edges: the points in two shadow maps that cut off a fragment's view of the line light between them.

Paper
    [Reimann2016]  Reimann, Dreier, "Occluding Edges Soft Shadows", GRAPP 2016.

Section map
    [Reimann2016 §3.1]              a texel's place in the other map          -> outreach.wgsl load_texel()
    [Reimann2016 §3.2 strategy 1]   edges where a surface turns away          -> outreach.wgsl is_edge_by_tilt()
    [Reimann2016 §3.2 strategy 2]   edges where the order of texels breaks    -> outreach.wgsl is_edge_by_order()
    [Reimann2016 §3.3]              an edge for every texel in its penumbra   -> outreach.wgsl walk()
    [Reimann2016 §3.4 substep 4.1]  umbra, penumbra or light                  -> lighting.wgsl edge_influence()
    [Reimann2016 §3.4 substep 4.2]  edges interpolated between rows           -> lighting.wgsl row_weights()
    [Reimann2016 §3.4 substep 4.3]  the visible share of the light            -> share.wgsl visible_share()
    [Reimann2016 §3.4 substep 4.3]  the influence of the light's two ends     -> influence.wgsl influence_between()
    [Reimann2016 §3.4 substep 4.4]  two edges merged                          -> lighting.wgsl merged_influence()

Departures from the paper
    - `penumbra="searched"` is the default: the edges only tell where to look, and everything along the row of the map
      that lies between the fragment and the light is gathered, from both ends. `penumbra="texture"` is the paper's: one
      edge for each texel, for every fragment that falls on it. Measured: docs/decisions/0011-occluding-edges.md.
    - `samples` points of the light, 5 by default; neighbours share their maps. The paper has two.
    - Maps are rectified: both see a plane through the light as the same row, so that the corresponding pixel is a
      disparity, and there is no metadata map. The tilt comes from the order of texels on one surface.
    - The outreach is a prefix minimum over each row in place of the paper's scatter, its bottleneck. Where several
      edges reach a texel, which the paper leaves open, the outermost in the other map's order is taken.
    - With `penumbra="texture"` a fragment that both ends see is lit, also where its texel lies in a penumbra. Two edges
      leave what both leave (substep 4.4, which the paper leaves open).
    - Shares are interpolated between the rows, not positions: the same along one edge, and bounded between two.
      `penumbra.rows=4` smooths them by a cubic B-spline; the paper has 2. A search interpolates over the
      segments, whose maps differ by parts of a row.
    - An edge beside a jump in depth lies between the two texels, not in the nearer one's middle.
    - `shading="whole"`: the frame is lit by the whole light's unshadowed radiance times the visible share.
      `shading="ends"` weighs the visible parts by the illumination at both ends of their segment, as the paper does,
      over the same sum for the whole segment. `shading.influence` is the paper's function f, which it leaves linear: a
      table of it at even places along a segment, what it gives the far end of what is visible there.

Use when
    the light is a line: for the accuracy of five maps here, `uniform` needs from 13 (shot `classroom_tube`) to more
    than 33 (`chair_line`, `bike_line`).
Fails when
    occluders are as thin as a texel of the map (scene `fence` with a low `resolution`). The paper's version,
    `OccludingEdges.preset("paper")`, lets light through behind receivers, jumps between two objects' edges, is too
    bright behind round objects, and fails wherever the ends do not see what the middle sees (scene `fence`).
Inputs
    line lights.
Cost
    `samples` shadow maps and as many edge maps, 8 bytes a texel; 3 look-ups per sample and pixel, and in penumbrae one
    for every texel between fragment and light.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.program import Program, Resource
from softshadows.scene.lights import Light
from softshadows.techniques.base import Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import SHADING_HELP, WholeLight, resolution_option
from softshadows.techniques.options import Choice, choice, one_of, option
from softshadows.techniques.workers import Workers, lights_of
from softshadows.visibility.line_maps.line_maps import COLUMNS, LineMaps, plan_line_maps

_FOLDER = "techniques/occluding_edges"
CELLS = constant(f"{_FOLDER}/edge_map.wgsl", "CELLS")
"""Stretches of a row that one lane walks each."""
BYTES_PER_TEXEL = 4 + 4
"""Bytes of a texel in the depth maps and in the edge map."""
NEAREST_OCCLUDER = 0.5
"""Share of the receivers' distance from which on occluders' edges lie within the maps, also just out of the picture."""
LOOKUPS = 3
"""Per sample: the hard test, and the edge map on both sides."""


class Searched(Choice):
    """What hides the light, by all that the maps know; edges only tell where to look."""

    name: ClassVar[str] = "searched"


class Texture(Choice):
    """The one edge at the fragment's texel, as in the paper."""

    name: ClassVar[str] = "texture"

    rows: int = option(
        default=4, help="rows of the maps that an edge is interpolated over; 2 is the paper's", choices=(1, 2, 4)
    )


class Ends(Choice):
    """Visible parts are weighed by the illumination at the ends of their segment, as in the paper."""

    name: ClassVar[str] = "ends"

    influence: tuple[float, ...] = option(
        default=(0.0, 1.0),
        help="of a segment's far end on what lies between its ends: a table from end to end",
        low=0.0,
        high=1.0,
        entries=(2, math.inf),
    )


class OccludingEdges(Technique):
    """Line lights by the edges that cut off a fragment's view of them. The module's text is its manual.

    The preset `paper` is the paper's own version.
    """

    name: ClassVar[str] = "occluding_edges"
    light_kinds: ClassVar[frozenset[str]] = frozenset({"line"})
    presets: ClassVar[Presets] = {
        "paper": {"samples": 2, "penumbra": "texture", "penumbra.rows": 2, "resolution": 800},
    }

    samples: int = option(default=5, help="points of the light that get a map; 2 is the paper's", low=2, high=32)
    edges: str = option(
        default="both",
        help="find edges where a surface turns away, where the order of texels breaks, or both",
        choices=("both", "order", "tilt"),
    )
    penumbra: Searched | Texture = choice(
        default=Searched(),
        converter=one_of(Searched, Texture),
        help="what hides the light: what a search of the maps finds, or the paper's one edge for each texel",
    )
    shading: WholeLight | Ends = choice(default=WholeLight(), converter=one_of(WholeLight, Ends), help=SHADING_HELP)
    resolution: int | str = resolution_option("auto")

    def build(self, context: RenderContext) -> TechniquePass:
        return OccludingEdgesPass(context, self)


class EdgeMaps:
    """Maps, their edges, and the passes that look into them, for one light at a time."""

    can_cache = True

    def __init__(self, context: RenderContext, technique: OccludingEdges, influence: wgpu.GPUBuffer) -> None:
        gpu, gbuffer = context.gpu, context.gbuffer
        self._context, self._technique = context, technique
        plan = plan_line_maps(
            gpu,
            gbuffer.size,
            technique.samples,
            technique.resolution,
            context.memory_budget,
            bytes_per_texel=BYTES_PER_TEXEL,
        )
        reach = 2.0 * (1.0 / NEAREST_OCCLUDER - 1.0) / (technique.samples - 1)
        self.maps = LineMaps(gpu, context.scene, gbuffer, plan, reach=reach)
        usage = wgpu.TextureUsage.STORAGE_BINDING | wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_SRC
        self.edge_map = gpu.texture((plan.atlas_size, plan.atlas_size), "r32uint", usage, "the edge map")
        self._dispatch = gpu.buffer(16, wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.INDIRECT, "the rows' dispatch")
        self._cells = gpu.storage_buffer(4 * CELLS * COLUMNS * plan.tile * plan.samples, "the rows of the maps")
        self.bytes = self.maps.bytes + 4 * plan.atlas_size**2 + self._dispatch.size + self._cells.size
        self._make_programs(influence)

    def _make_programs(self, influence: wgpu.GPUBuffer) -> None:
        technique, context = self._technique, self._context
        texture = technique.penumbra if isinstance(technique.penumbra, Texture) else Texture()

        def program(name: str, resources: dict[str, Resource], **constants: float) -> Program:
            looks = self.maps.resources
            path, entry = f"{_FOLDER}/{name}.wgsl", f"cs_{name}"
            return Program(context.gpu, path, entry, {**looks, **resources}, constants=constants)

        edges: dict[str, Resource] = {"edge_map": self.edge_map, "cells": self._cells}
        self._rows = program("rows", {"state": self.maps.state, "dispatch": self._dispatch})
        self._outreach = program(
            "outreach", edges, uses_tilt=technique.edges != "order", uses_order=technique.edges != "tilt"
        )
        self._lighting = program(
            "lighting",
            {**context.gbuffer.resources, **edges, "visibility": context.visibility, "influence": influence},
            by_ends=isinstance(technique.shading, Ends),
            is_searched=isinstance(technique.penumbra, Searched),
            edge_rows=texture.rows,
        )

    def encode(self, commands: Commands, index: int) -> None:
        """Find light `index`'s visibility."""
        (width, height), gpu = self._context.gbuffer.size, self._context.gpu
        self.maps.encode_receivers(commands, index)
        self.maps.encode_fit(commands)
        self.maps.encode_maps(commands)
        with commands.compute("outreach") as compute:
            self._rows.dispatch(compute, (1,))
            self._outreach.dispatch_indirect(compute, self._dispatch)
        with commands.compute("lookup") as compute:
            self._lighting.dispatch(compute, (-(-width // 8), -(-height // 8)))
        commands.account(width * height * LOOKUPS * self._technique.samples / gpu.budget.lookups_per_ms)


class OccludingEdgesPass(TechniquePass):
    """The technique at work."""

    def __init__(self, context: RenderContext, technique: OccludingEdges) -> None:
        super().__init__()
        self._context, self._technique = context, technique
        ends = technique.shading if isinstance(technique.shading, Ends) else Ends()
        influence = _with_integral(ends.influence)
        self._influence = context.gpu.storage_buffer(influence.nbytes, "the influence of a segment's end")
        context.gpu.write(self._influence, 0, influence, what="constant")
        self._edge_maps: Workers[str, EdgeMaps] = Workers(self._new_maps, context.memory_budget)
        self.lights: tuple[Light, ...] = ()
        self.by_light: list[tuple[EdgeMaps, int]] = []  # per light: its maps, and its index there

    def _new_maps(self, kind: str) -> EdgeMaps:
        return EdgeMaps(self._context, self._technique, self._influence)

    def write(self, lights: Mapping[int, Light]) -> None:
        self.lights = tuple(lights.values())
        by_light = self._edge_maps.assign({layer: light.kind for layer, light in lights.items()})
        for edge_maps, layers in lights_of(by_light).items():
            own = [(lights[layer], layer) for layer in layers]
            edge_maps.maps.write(own, keeps_looser_fits=self.keeps_looser_fits)
        self.by_light = [*by_light.values()]
        self.shadow_maps = self._technique.samples * len(lights)
        self.lookups_per_pixel = float(LOOKUPS * self.shadow_maps)
        self.bytes = self._edge_maps.bytes + self._influence.size

    def encode(self, commands: Commands) -> None:
        for edge_maps, index in self.by_light:
            edge_maps.encode(commands, index)


def _with_integral(table: Sequence[float]) -> np.ndarray:
    """(n, 2) float32: a table's numbers, of a function on [0, 1], and its integral up to each of their places."""
    values = np.array(table)
    steps = 0.5 * (values[1:] + values[:-1]) / (len(values) - 1)
    return np.stack([values, np.concatenate([[0.0], np.cumsum(steps)])], axis=-1).astype(np.float32)
