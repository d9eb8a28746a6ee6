"""Penumbra wedges at work on the GPU: two passes per light, and nothing read back that decides what comes next.

    silhouettes.wgsl   planes, edges and clusters in light units; which edges are silhouettes
    visibility.wgsl    tiles of receivers walk over what is in their shafts, and combine it by
        wedges.wgsl    every silhouette's coverage of the light, blended, or
        union.wgsl     the layers over 256 points of the light, in its place

Edges and objects are the scene's (edge_buffers.py); what depends on a light is written for one light after the other
into the same buffers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.layout import F32, U32, Struct, Vec3f, dtype, pack
from softshadows.gpu.program import Bindings, Program
from softshadows.lights.record import Light as LightRecord
from softshadows.lights.record import light_record
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext, TechniquePass
from softshadows.techniques.penumbra_wedges.dispatches import TILE, plan
from softshadows.techniques.penumbra_wedges.edge_buffers import (
    CLUSTER,
    EdgeBuffers,
    WedgeCluster,
    WedgeEdge,
    WedgeObject,
)

_FOLDER = "techniques/penumbra_wedges"
GROUPS_PER_ROW = constant(f"{_FOLDER}/silhouettes.wgsl", "GROUPS_PER_ROW")
RECEIVER_OFFSET = 2.0**-18
"""How far receivers are moved off their surface, and the light off a lamp's, as a share of the largest coordinate
around: 4 µm per metre. Four times what frees rays (truth/tracer.py), since light units round once more."""
THINNEST = 1e-3
"""A light's shorter side over its longer one; a thinner light is taken for one of this shape (papers.md, section 6)."""


class WedgeSide(Struct):
    """One side of a light (light_frame.wgsl)."""

    light: LightRecord
    center_ws: Vec3f  # before the light by receiver_offset
    receiver_offset: F32  # metres
    right_per_half: Vec3f  # right over half the width: what turns metres into light units
    object_count: U32
    up_per_half: Vec3f
    edge_cluster_count: U32
    back_ws: Vec3f
    triangle_cluster_count: U32
    right_half_ws: Vec3f  # right times half the width
    is_second_side: U32
    up_half_ws: Vec3f


class TileBand(Struct):
    """Rows of tiles that one dispatch does: the first one's number."""

    first_row: U32


@dataclass(eq=False)
class LightSide:
    """One side of one light: its buffers, and the bindings that hold them, those of visibility band by band."""

    record: wgpu.GPUBuffer
    objects: wgpu.GPUBuffer
    silhouettes: list[Bindings]
    visibility: list[Bindings]

    @property
    def bytes(self) -> int:
        return self.record.size + self.objects.size


class WedgePass(TechniquePass):
    """The technique at work: wedges.wgsl with these constants, or union.wgsl for None.

    Raises OptionError for a scene with alpha-masked surfaces.
    """

    def __init__(self, context: RenderContext, constants: Mapping[str, float] | None) -> None:
        super().__init__()
        _check_opaque(context.scene.geometry)
        self._context, self._constants = context, constants
        self._edges = EdgeBuffers(context.gpu, context.scene.geometry)
        self._geometry = context.scene.geometry
        self._build()

    # -- What the scene decides ----------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Plan, buffers and programs for the scene's edges."""
        self._plan = plan(self._context.gpu, self._edges, self._context.gbuffer.size, self._constants is None)
        self._buffers = self._build_buffers()
        self._bands = [self._context.gpu.uniform(TileBand(first_row=row)) for row in self._plan.band_rows[:-1]]
        self._silhouettes = self._silhouette_programs()
        self._visibility = self._visibility_program()
        self._sides: list[LightSide] = []
        self._scene_bytes = self._edges.bytes + sum(buffer.size for buffer in (*self._buffers.values(), *self._bands))

    def _build_buffers(self) -> dict[str, wgpu.GPUBuffer]:
        """By the shaders' names: what silhouettes.wgsl finds for a light, and what receivers keep."""
        edges = self._edges
        sizes = {
            "planes": (16, edges.triangle_count, "the triangles' planes"),
            "edges": (dtype(WedgeEdge).itemsize, edges.edge_count, "the silhouettes' edges"),
            "clusters": (dtype(WedgeCluster).itemsize, edges.cluster_count, "the clusters of edges and triangles"),
            "light_is_cut": (4, 1, "whether a light is cut"),
            "states": (self._plan.state_bytes, 1, "what receivers keep between dispatches"),
        }
        return {
            name: self._context.gpu.storage_buffer(struct_bytes * max(count, 1), what)
            for name, (struct_bytes, count, what) in sizes.items()
        }

    def _silhouette_programs(self) -> dict[Program, int]:
        """The programs in the order they run, and how many workgroups they take."""
        edges, buffers = self._edges, self._buffers
        resources = {
            **self._context.scene.resources,
            **edges.resources,
            **{name: buffers[name] for name in ("planes", "edges", "clusters", "light_is_cut")},
        }
        constants = {"from_every_sample": self._constants is None}
        groups = {
            "cs_planes": -(-edges.triangle_count // CLUSTER),
            "cs_edges": edges.edge_cluster_count,
            "cs_triangles": edges.triangle_cluster_count,
        }
        path = f"{_FOLDER}/silhouettes.wgsl"
        return {
            Program(self._context.gpu, path, entry, resources, constants=constants): count
            for entry, count in groups.items()
            if count
        }

    def _visibility_program(self) -> Program:
        context, edges, buffers = self._context, self._edges, self._buffers
        is_union = self._constants is None
        records = {"edge_records": edges.edge_records} if is_union else {}
        resources = {
            **context.gbuffer.resources,
            **{name: buffers[name] for name in ("edges", "clusters", "planes", "states")},
            **records,
            "triangle_records": edges.triangle_records,
            "visibility": context.visibility,
        }
        return Program(
            context.gpu,
            f"{_FOLDER}/visibility.wgsl",
            "cs_visibility",
            resources,
            constants={**(self._constants or {}), **self._plan.constants},
            stand_ins={f"{_FOLDER}/wedges.wgsl": f"{_FOLDER}/union.wgsl"} if is_union else None,
        )

    # -- What the lights decide ----------------------------------------------------------------------------------------

    def write(self, lights: Mapping[int, Light]) -> None:
        geometry = self._context.scene.geometry
        if geometry is not self._geometry:
            if self._edges.update(geometry):
                self._build()
            self._geometry = geometry
        sides = [
            (light, layer, is_second)
            for layer, light in lights.items()
            for is_second in ((False,) if light.one_sided else (False, True))
        ]
        while len(self._sides) < len(sides):
            self._sides.append(self._new_side())
        del self._sides[len(sides) :]
        self.bytes = self._scene_bytes + sum(side.bytes for side in self._sides)
        for side, (light, layer, is_second) in zip(self._sides, sides, strict=True):
            self._write_side(side, light, layer, is_second)

    def _new_side(self) -> LightSide:
        gpu = self._context.gpu
        record = gpu.storage_buffer(dtype(WedgeSide).itemsize, "a side of a light")
        size = dtype(WedgeObject).itemsize * max(self._edges.silhouette_count, 1)
        objects = gpu.storage_buffer(size, "the objects")
        own = {"side": record} if self._constants is None else {"side": record, "objects": objects}
        return LightSide(
            record,
            objects,
            silhouettes=[program.bind(side=record) for program in self._silhouettes],
            visibility=[self._visibility.bind(band=band, **own) for band in self._bands],
        )

    def _write_side(self, side: LightSide, light: Light, layer: int, is_second: bool) -> None:
        """Write one side of a light. The second side of a two-sided one is turned half around its right axis."""
        right, up, back = light.axes
        if is_second:
            up, back = -up, -back
        a, b = light.half_extent if light.has_size else (1.0, 1.0)
        a, b = max(a, THINNEST * b), max(b, THINNEST * a)
        bounds = self._geometry.bounds
        extent = max(np.abs(corners).max() for corners in (bounds, light.center, bounds - light.center))
        offset = RECEIVER_OFFSET * float(extent)
        center = light.center - back * offset
        edges = self._edges
        objects = edges.silhouettes(np.stack([right / a, up / b, back]), center)
        record = WedgeSide(
            light=light_record(light, layer),
            center_ws=tuple(center),
            receiver_offset=offset,
            right_per_half=tuple(right / a),
            object_count=len(objects),
            up_per_half=tuple(up / b),
            edge_cluster_count=edges.edge_cluster_count,
            back_ws=tuple(back),
            triangle_cluster_count=edges.triangle_cluster_count,
            right_half_ws=tuple(right * a),
            up_half_ws=tuple(up * b),
            is_second_side=int(is_second),
        )
        self._context.gpu.write(side.record, 0, pack(record), what="light")
        if len(objects):
            self._context.gpu.write(side.objects, 0, objects, what="light")

    # -- A frame -------------------------------------------------------------------------------------------------------

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._buffers["light_is_cut"])
        for side in self._sides:
            with commands.compute("silhouettes") as compute:
                for (program, count), bindings in zip(self._silhouettes.items(), side.silhouettes, strict=True):
                    program.dispatch(compute, (min(count, GROUPS_PER_ROW), -(-count // GROUPS_PER_ROW)), bindings)
            self._encode_visibility(commands, side)

    def _encode_visibility(self, commands: Commands, side: LightSide) -> None:
        columns = -(-self._context.gbuffer.size[0] // TILE)
        rows = self._plan.band_rows
        for first, end, bindings in zip(rows[:-1], rows[1:], side.visibility, strict=True):
            if self._plan.parts > 1:
                commands.encoder.clear_buffer(self._buffers["states"])
            with commands.compute("wedges") as compute:
                for _ in range(self._plan.parts):
                    self._visibility.dispatch(compute, (columns, end - first), bindings)
            commands.account(self._plan.milliseconds / self._plan.bands)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"light_is_cut": (self._buffers["light_is_cut"], "<u4", (1,))}

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        bent = np.count_nonzero(~self._edges.is_closed & ~self._edges.is_card)
        self.warnings = []
        if bent and self._constants is not None:
            self.warnings.append(
                f"penumbra_wedges: {bent} of {len(self._edges.is_closed)} objects are neither closed nor flat; each is "
                "taken as two sheets, what turns its front to the light and what turns its back (blending='union' "
                "needs no closed surfaces)"
            )
        if results["light_is_cut"][0]:
            self.warnings.append(
                "penumbra_wedges: geometry cuts through a light, and visibility may err; move the light clear of it"
            )


def _check_opaque(geometry: Geometry) -> None:
    masked = len(geometry.triangles) - geometry.opaque_count
    if masked:
        materials = {geometry.material_index[index] for index in range(geometry.opaque_count, len(geometry.triangles))}
        names = sorted(geometry.materials[index].name or "unnamed" for index in materials)
        raise OptionError(
            f"technique 'penumbra_wedges' cannot do alpha-masked surfaces, whose outline is in a texture; {masked} "
            f"triangles have some (material {', '.join(names[:3])}). Choose 'uniform' or 'adaptive' for this scene."
        )
