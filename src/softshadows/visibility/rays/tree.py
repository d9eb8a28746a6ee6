"""The scene's triangles in a tree of boxes that rays walk through on the GPU.

    sah.py             the tree's shape, chosen on the CPU
    lbvh.py            or on the GPU, for large scenes
    parts.py           what of it changes when nodes move
    refit.wgsl         its boxes, found on the GPU: after the shape is new, and after nodes have moved
    tree_node.wgsl     what a node is
    occluded.wgsl      the walk

Nothing here waits for the GPU: the CPU knows the counts, and a frame encodes what has changed. Boxes lie on a grid of
2¹⁶ cells over the scene and are rounded outwards, which makes a node 16 bytes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import wgpu

from softshadows.errors import DeviceError, OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import Program, Resource
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.scene.geometry import Geometry
from softshadows.visibility.rays.grid import TreeGrid, grid_over, groups_of
from softshadows.visibility.rays.lbvh import Lbvh
from softshadows.visibility.rays.parts import Change, Parts
from softshadows.visibility.rays.shape import MOST_TRIANGLES

_USAGE = wgpu.BufferUsage
FAN = constant("visibility/rays/refit.wgsl", "FAN")
"""Boxes below each box of the pyramid."""
BUILDERS = ("auto", "cpu", "gpu")
MOST_ON_CPU = 300_000
"""Triangles up to which the CPU builds: about a second's work, for a tree that is walked faster."""
TRIANGLE_BYTES = 48
CUT_SHORT = (
    "rays: the device ended some walks through the scene's tree before their end, so that light may show where there "
    "is shadow. Render fewer samples, or use visibility='map'."
)
"""A frame's warning: software drivers bound the rounds of a shader's loops."""


class Bvh:
    """The tree of one SceneBuffers. `encode` brings it up to date; `resources` are for programs that walk it.

    `builder`: who chooses the tree's shape, "cpu", "gpu", or "auto" by the scene's size. Raises OptionError for other
    words, DeviceError where the adapter cannot bind the scene's triangles at once.
    """

    def __init__(self, scene: SceneBuffers, builder: str = "auto") -> None:
        if builder not in BUILDERS:
            raise OptionError(f"builder must be one of {', '.join(BUILDERS)}, got {builder!r}")
        gpu, geometry = scene.gpu, scene.geometry
        self.gpu, self._scene = gpu, scene
        self._fitted: Geometry | None = None
        count = len(geometry.triangles)
        if count > MOST_TRIANGLES:
            raise DeviceError(f"rays can walk through {MOST_TRIANGLES} triangles; the scene has {count}.")
        by_gpu = count > 0 and (builder == "gpu" or (builder == "auto" and count > MOST_ON_CPU))
        most_nodes = max(2 * count - 1, 0)  # with a triangle in each leaf
        self.bytes = 0
        self.levels = _pyramid_levels(count)
        pyramid_bytes = max(16 * sum(self.levels), Lbvh.scratch_bytes(count) if by_gpu else 0)
        self.grid = self._buffer(dtype(TreeGrid).itemsize, _USAGE.UNIFORM, "the tree's grid")
        self.nodes = self._buffer(16 * most_nodes, _USAGE.STORAGE, "the tree of the triangles")
        self.triangles = self._buffer(TRIANGLE_BYTES * count, _USAGE.STORAGE, "the tree's triangles")
        self._order = self._buffer(4 * count, _USAGE.STORAGE, "the order of the tree's triangles")
        self._shapes = self._buffer(16 * most_nodes, _USAGE.STORAGE, "the shape of the tree")
        self._pyramid = self._buffer(pyramid_bytes, _USAGE.STORAGE, "the boxes below the tree")
        self._parts = Parts(geometry) if count and not by_gpu else None
        self._lbvh = self._make_lbvh() if by_gpu else None
        places = {"tree": self.grid, "tree_triangles": self.triangles, "tree_nodes": self.nodes}
        self._gather, self._reduce, self._bound = self.make_refit(places)

    def _buffer(self, size: int, usage: int, what: str) -> wgpu.GPUBuffer:
        buffer = self.gpu.buffer(max(size, 256), usage, what)
        self.bytes += buffer.size
        return buffer

    def _make_lbvh(self) -> Lbvh:
        lbvh = Lbvh(
            self._scene,
            grid=self.grid,
            order=self._order,
            shapes=self._shapes,
            nodes=self.nodes,
            scratch=self._pyramid,
        )
        self.bytes += lbvh.bytes
        return lbvh

    def make_refit(
        self, places: Mapping[str, Resource], stand_ins: Mapping[str, str] | None = None
    ) -> tuple[Program, list[Program], Program]:
        """The steps of a refit into `places`: grid, triangles and nodes, by the names of refit.wgsl."""
        resources: dict[str, Resource] = {
            "order": self._order,
            "pyramid": self._pyramid,
            "shapes": self._shapes,
            "vertex_positions_ws": self._scene.positions,
            "triangle_indices": self._scene.indices,
            **places,
        }

        def program(entry: str, **constants: float) -> Program:
            file = "visibility/rays/refit.wgsl"
            return Program(self.gpu, file, entry, resources, constants=constants, stand_ins=stand_ins)

        reduce = [program("cs_reduce", level=level) for level in range(1, len(self.levels))]
        return program("cs_gather"), reduce, program("cs_bound")

    @property
    def has_cutouts(self) -> bool:
        """Has the scene triangles with an alpha mask?"""
        return self._scene.triangle_count > self._scene.opaque_count

    @property
    def resources(self) -> dict[str, Resource]:
        """What occluded.wgsl declares, and masked.wgsl where the scene has alpha masks."""
        own: dict[str, Resource] = {
            "tree": self.grid,
            "tree_nodes": self.nodes,
            "tree_triangles": self.triangles,
        }
        return {**own, **self._scene.masked_resources} if self.has_cutouts else own

    @property
    def stand_ins(self) -> dict[str, str]:
        """For shaders that include occluded.wgsl: without alpha masks, nothing is read to find them."""
        return {} if self.has_cutouts else {"visibility/rays/cutouts.wgsl": "visibility/rays/no_cutouts.wgsl"}

    def encode(self, commands: Commands) -> None:
        """Fit the boxes to where the triangles are now, unless they have not moved since the last time."""
        geometry = self._scene.geometry
        if geometry is self._fitted:
            return
        self._fitted = geometry
        if self._lbvh is not None:
            self._build(self._lbvh, commands, geometry)
        elif self._parts is not None:
            change = self._parts.follow(geometry)
            self._write(change, geometry)
            self._fit(commands, change.node_count)
        else:
            self._write(Change(0), geometry)

    def _build(self, lbvh: Lbvh, commands: Commands, geometry: Geometry) -> None:
        """A new tree, by the GPU: of boxes with a triangle each, which decide how many are to share one."""
        most_nodes = 2 * len(geometry.triangles) - 1
        self._write(Change(most_nodes), geometry)
        lbvh.encode_split(commands)
        self._fit(commands, most_nodes)
        lbvh.encode_merge(commands)
        with commands.compute("tree") as compute:
            self._bound.dispatch(compute, groups_of(most_nodes))

    def _fit(self, commands: Commands, node_count: int) -> None:
        """Boxes for the tree whose shape is known."""
        with commands.compute("tree") as compute:
            for program, count in zip([self._gather, *self._reduce], self.levels, strict=True):
                program.dispatch(compute, groups_of(count))
            self._bound.dispatch(compute, groups_of(node_count))

    def _write(self, change: Change, geometry: Geometry) -> None:
        write = self.gpu.write
        write(self.grid, 0, pack(grid_over(geometry, change.node_count)), what="scene")
        for place, order in change.order:
            write(self._order, 4 * place, order.astype(np.uint32), what="scene")
        for node, records in change.records:
            write(self._shapes, 16 * node, records, what="scene")


def tree_of(scene: SceneBuffers) -> Bvh:
    """The scene's tree: built when somebody first asks for it, and kept as long as the scene."""
    if scene.tree is None:
        scene.tree = Bvh(scene)
    return scene.tree


def _pyramid_levels(count: int) -> list[int]:
    """Boxes in each level of the pyramid, from one per triangle to one."""
    levels = [count]
    while levels[-1] > 1:
        levels.append(-(-levels[-1] // FAN))
    return levels
