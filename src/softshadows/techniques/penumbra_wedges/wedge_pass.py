"""Penumbra wedges at work on the GPU: two passes per light, and nothing read back that decides what comes next.

    silhouettes.wgsl   planes, edges and clusters in light units; which edges are silhouettes
    wedges.wgsl        every silhouette's coverage of the light, blended (uses shaft, parts and coverage.wgsl), or
    union.wgsl         the layers over 256 points of the light

Edges and objects are the scene's (edge_buffers.py); what depends on a light is written for one light after the other
into the same buffers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.kernel import Kernel
from softshadows.gpu.layout import F32, U32, Struct, Vec3f, dtype, pack
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

_HERE = Path(__file__).parent
_USAGE = wgpu.BufferUsage
GROUPS_PER_ROW = 32768
"""Of a long dispatch, folded into rows (silhouettes.wgsl)."""
RECEIVER_OFFSET = 2.0**-18
"""How far receivers are moved off their surface, and the light off a lamp's, as a share of the largest coordinate
around: 4 µm per metre. Four times what frees rays (truth/tracer.py), since light units round once more."""
THINNEST = 1e-3
"""A light's shorter side over its longer one; a thinner light is taken for one of this shape (papers.md, section 6)."""


class WedgeLight(Struct):
    """One side of a light (light_frame.wgsl)."""

    center_ws: Vec3f
    visibility_offset: U32
    right_per_half: Vec3f  # right over half the width: what turns metres into light units
    object_count: U32
    up_per_half: Vec3f
    edge_cluster_count: U32
    back_ws: Vec3f
    triangle_cluster_count: U32
    right_half_ws: Vec3f  # right times half the width
    is_point: U32
    up_half_ws: Vec3f
    is_second_side: U32
    receiver_offset: F32  # metres


@dataclass(eq=False)
class Turn:
    """One side of one light: its buffers, and the bind groups that hold them, by kernel."""

    light: wgpu.GPUBuffer
    objects: wgpu.GPUBuffer
    bindings: dict[str, dict[int, wgpu.GPUBindGroup]]


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
        self._written: tuple[Light, ...] | None = None
        self._build()

    # -- What the scene decides ----------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Buffers and kernels for the scene's edges."""
        gpu, edges = self._context.gpu, self._edges

        def array(struct_bytes: int, count: int, what: str) -> wgpu.GPUBuffer:
            size = struct_bytes * max(count, 1)
            self.bytes += size
            return gpu.storage_buffer(size, what)

        self.bytes = edges.bytes
        cluster = dtype(WedgeCluster).itemsize
        self._buffers = {
            "planes": array(16, edges.triangle_count, "the triangles' planes"),
            "edges": array(dtype(WedgeEdge).itemsize, edges.edge_count, "the silhouettes' edges"),
            "edge_clusters": array(cluster, edges.edge_cluster_count, "the clusters of edges"),
            "triangle_clusters": array(cluster, edges.triangle_cluster_count, "the clusters of triangles"),
            "light_is_cut": array(4, 1, "whether a light is cut"),
        }
        self._plan = plan(gpu, edges, self._context.gbuffer.size, self._constants is None)
        self._buffers["states"] = array(self._plan.state_bytes, 1, "what receivers keep between dispatches")
        self._kernels = {**self._silhouette_kernels(), "visibility": self._visibility_kernel()}
        self._turns: list[Turn] = []
        self._bands = [self._band(first_row) for first_row in self._plan.band_rows[:-1]]
        self._scene_bytes = self.bytes

    def _silhouette_kernels(self) -> dict[str, Kernel]:
        scene, edges, buffers = self._context.scene, self._edges, self._buffers
        resources = {
            "cs_planes": {0: scene.positions, 1: scene.indices, 2: scene.faces, 6: buffers["planes"]},
            "cs_edges": {
                0: scene.positions,
                3: edges.edge_records,
                5: edges.edge_ranges,
                6: buffers["planes"],
                7: buffers["edges"],
                8: buffers["edge_clusters"],
            },
            "cs_triangles": {
                0: scene.positions,
                1: scene.indices,
                4: edges.triangle_records,
                5: edges.triangle_ranges,
                8: buffers["triangle_clusters"],
                9: buffers["light_is_cut"],
            },
        }
        constants = {"from_every_sample": self._constants is None}
        file = _HERE / "silhouettes.wgsl"
        return {
            entry: Kernel(self._context.gpu, file, entry, {1: used}, constants) for entry, used in resources.items()
        }

    def _visibility_kernel(self) -> Kernel:
        context, edges, buffers = self._context, self._edges, self._buffers
        gbuffer = context.gbuffer
        receivers = {0: gbuffer.uniforms, 1: gbuffer.position.create_view(), 2: gbuffer.normal.create_view()}
        shared = {
            0: buffers["edges"],
            1: buffers["edge_clusters"],
            2: buffers["planes"],
            3: edges.triangle_records,
            4: buffers["triangle_clusters"],
            5: context.visibility,
            6: buffers["states"],
        }
        is_union = self._constants is None
        if is_union:
            shared[7] = edges.edge_records
        file = _HERE / ("union.wgsl" if is_union else "wedges.wgsl")
        constants = {**(self._constants or {}), **self._plan.constants}
        return Kernel(context.gpu, file, "cs_visibility", {0: receivers, 1: shared}, constants)

    def _band(self, first_row: int) -> wgpu.GPUBindGroup:
        """The visibility kernel's binding of a band that starts with this row of tiles."""
        data = np.array([first_row, 0, 0, 0], np.uint32)
        self.bytes += data.nbytes
        uniform = self._context.gpu.device.create_buffer(size=data.nbytes, usage=_USAGE.UNIFORM | _USAGE.COPY_DST)
        self._context.gpu.device.queue.write_buffer(uniform, 0, data)
        return self._kernels["visibility"].bind(3, {0: uniform})

    # -- What the lights decide ----------------------------------------------------------------------------------------

    def set_lights(self, lights: Sequence[Light]) -> None:
        geometry = self._context.scene.geometry
        if geometry is not self._geometry:
            if self._edges.update(geometry):
                self._build()
            self._geometry, self._written = geometry, None
        if tuple(lights) == self._written:
            return
        self._written = tuple(lights)
        sides = [
            (light, layer, is_second)
            for layer, light in enumerate(lights)
            for is_second in ((False,) if light.one_sided else (False, True))
        ]
        while len(self._turns) < len(sides):
            self._turns.append(self._new_turn())
        del self._turns[len(sides) :]
        self.bytes = self._scene_bytes + sum(turn.light.size + turn.objects.size for turn in self._turns)
        for turn, side in zip(self._turns, sides, strict=True):
            self._write_turn(turn, *side)

    def _new_turn(self) -> Turn:
        gpu, kernels = self._context.gpu, self._kernels
        light = gpu.device.create_buffer(size=dtype(WedgeLight).itemsize, usage=_USAGE.STORAGE | _USAGE.COPY_DST)
        size = dtype(WedgeObject).itemsize * max(self._edges.silhouette_count, 1)
        objects = gpu.storage_buffer(size, "the objects")
        bindings = {name: {0: kernels[name].bind(0, {0: light})} for name in kernels if name != "visibility"}
        own = {0: light} if self._constants is None else {0: light, 1: objects}
        bindings["visibility"] = {2: kernels["visibility"].bind(2, own)}
        return Turn(light, objects, bindings)

    def _write_turn(self, turn: Turn, light: Light, layer: int, is_second: bool) -> None:
        """Write one side of a light. The second side of a two-sided one is turned half around its right axis."""
        right, up, back = light.axes
        if is_second:
            up, back = -up, -back
        is_point = light.half_extent == (0.0, 0.0)
        a, b = (1.0, 1.0) if is_point else light.half_extent
        a, b = max(a, THINNEST * b), max(b, THINNEST * a)
        bounds = self._geometry.bounds
        extent = max(np.abs(corners).max() for corners in (bounds, light.center, bounds - light.center))
        offset = RECEIVER_OFFSET * float(extent)
        center = light.center - back * offset
        edges, (width, height) = self._edges, self._context.gbuffer.size
        objects = edges.silhouettes(np.stack([right / a, up / b, back]), center)
        uniforms = WedgeLight(
            center_ws=tuple(center),
            visibility_offset=layer * width * height,
            right_per_half=tuple(right / a),
            object_count=len(objects),
            up_per_half=tuple(up / b),
            edge_cluster_count=edges.edge_cluster_count,
            back_ws=tuple(back),
            triangle_cluster_count=edges.triangle_cluster_count,
            right_half_ws=tuple(right * a),
            is_point=int(is_point),
            up_half_ws=tuple(up * b),
            is_second_side=int(is_second),
            receiver_offset=offset,
        )
        queue = self._context.gpu.device.queue
        queue.write_buffer(turn.light, 0, pack(uniforms))
        if len(objects):
            queue.write_buffer(turn.objects, 0, objects)

    # -- A frame -------------------------------------------------------------------------------------------------------

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._buffers["light_is_cut"])
        groups = {
            "cs_planes": -(-self._edges.triangle_count // CLUSTER),
            "cs_edges": self._edges.edge_cluster_count,
            "cs_triangles": self._edges.triangle_cluster_count,
        }
        for turn in self._turns:
            with commands.compute("silhouettes") as compute:
                for name, count in groups.items():
                    if count:
                        self._kernels[name].begin(compute, turn.bindings[name])
                        compute.dispatch_workgroups(min(count, GROUPS_PER_ROW), -(-count // GROUPS_PER_ROW))
            self._encode_visibility(commands, turn)

    def _encode_visibility(self, commands: Commands, turn: Turn) -> None:
        columns = -(-self._context.gbuffer.size[0] // TILE)
        rows = self._plan.band_rows
        for first, end, band in zip(rows[:-1], rows[1:], self._bands, strict=True):
            if self._plan.parts > 1:
                commands.encoder.clear_buffer(self._buffers["states"])
            with commands.compute("wedges") as compute:
                self._kernels["visibility"].begin(compute, {**turn.bindings["visibility"], 3: band})
                for _ in range(self._plan.parts):
                    compute.dispatch_workgroups(columns, end - first)
            commands.account(self._plan.milliseconds / len(self._bands))

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"light_is_cut": (self._buffers["light_is_cut"], "<u4", (1,))}

    def take_results(self, results: Mapping[str, np.ndarray]) -> None:
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
