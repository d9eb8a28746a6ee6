"""The scene's tree once more, in a light's own space: boxes and triangles for walks that look at the light's plane.

The shape is the scene's (tree.py); boxes and corners are found anew for every light, and when light or scene move.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import Resource
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.lights.record import Light as LightRecord
from softshadows.lights.record import light_record
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.visibility.maps.extents import reaches_into
from softshadows.visibility.rays.grid import NODE_COUNT_OFFSET, TreeGrid, grid_over, groups_of
from softshadows.visibility.rays.tree import Bvh

_USAGE = wgpu.BufferUsage
SPACE = {"visibility/rays/world_space.wgsl": "visibility/rays/light_tree_space.wgsl"}
SOLID_MARGIN = 1e-4
"""Share of the scene's diagonal that a light must keep from a solid, not to be taken to reach into it."""


class TreeStore:
    """Room for the boxes and triangles of `tree` in the space of one light at a time: of the one it was last fitted to.

    80 bytes a triangle. Raises DeviceError where the adapter cannot bind the scene's triangles at once: by default
    limits, 2.7 million of them.
    """

    can_cache = True

    def __init__(self, gpu: Gpu, tree: Bvh) -> None:
        self.fitted: tuple[Light, Geometry] | None = None
        self.nodes = gpu.storage_buffer(max(tree.nodes.size, 256), "a light's tree")
        self.triangles = gpu.storage_buffer(max(tree.triangles.size, 256), "the triangles of a light's tree")
        self.bytes = self.nodes.size + self.triangles.size


class LightTree:
    """`tree` in one light's space, in a store that others may share. `resources` are for programs that walk it."""

    def __init__(self, gpu: Gpu, scene: SceneBuffers, tree: Bvh, store: TreeStore) -> None:
        self._gpu, self._scene, self._tree, self._store = gpu, scene, tree, store
        self.light = gpu.storage_buffer(dtype(LightRecord).itemsize, "the light of a tree")
        self.grid = gpu.buffer(dtype(TreeGrid).itemsize, _USAGE.UNIFORM | _USAGE.STORAGE, "the grid of a light's tree")
        self._gather, self._reduce, self._bound = tree.make_refit(
            {"tree": self.grid, "tree_triangles": store.triangles, "tree_nodes": store.nodes, "light": self.light},
            SPACE,
        )

    @property
    def resources(self) -> dict[str, Resource]:
        """By the names that a walk in light space declares."""
        return {
            "light": self.light,
            "light_tree": self.grid,
            "tree_nodes": self._store.nodes,
            "tree_triangles": self._store.triangles,
        }

    def write(self, light: Light, index: int) -> None:
        """Write the frame's light, of which the visibility is number `index`."""
        geometry = self._scene.geometry
        record = _along_right(light_record(light, index))
        self._gpu.write(self.light, 0, pack(record), what="light")
        margin = SOLID_MARGIN * geometry.diagonal
        solid_count = 0 if reaches_into(geometry.solid_boxes, light, margin) else self._scene.solid_count
        corners = np.stack(np.meshgrid(*geometry.bounds.T, indexing="ij"), axis=-1).reshape(-1, 3)
        axes = np.array([record.right_ws, record.up_ws, record.back_ws])
        local = corners @ axes.T
        bounds = np.stack([local.min(axis=0), local.max(axis=0)])
        self._gpu.write(self.grid, 0, pack(grid_over(geometry, 0, bounds, solid_count)), what="light")
        self._wanted = (light, geometry)

    def encode(self, commands: Commands) -> None:
        """Fit the tree to the light, unless the store holds just that."""
        encoder = commands.encoder
        encoder.copy_buffer_to_buffer(self._tree.grid, NODE_COUNT_OFFSET, self.grid, NODE_COUNT_OFFSET, 4)
        if self._store.fitted == self._wanted:
            return
        self._store.fitted = self._wanted
        with commands.compute("light_tree") as compute:
            for program, count in zip([self._gather, *self._reduce], self._tree.levels, strict=True):
                program.dispatch(compute, groups_of(count))
            self._bound.dispatch(compute, groups_of(max(2 * self._tree.levels[0] - 1, 1)))


def _along_right(record: LightRecord) -> LightRecord:
    """The same light, with the extent of one that has only a height along its right axis: a line, to walks."""
    if record.half_width > 0.0 or record.half_height == 0.0:
        return record
    across = tuple(-component for component in record.right_ws)
    return replace(
        record, right_ws=record.up_ws, up_ws=across, half_width=record.half_height, half_height=record.half_width
    )
