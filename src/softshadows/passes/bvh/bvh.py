"""The scene's triangles in a tree of boxes that rays walk through on the GPU.

    sah.py             the tree's shape, chosen on the CPU
    refit.wgsl         its boxes, found on the GPU: after the shape is new, and after nodes have moved
    tree_node.wgsl     what a node is
    occluded.wgsl      the walk

Nothing here waits for the GPU: the CPU knows the counts, and a frame encodes what has changed. Boxes lie on a grid of
2¹⁶ cells over the scene and are rounded outwards, which makes a node 16 bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.errors import DeviceError
from softshadows.gpu.commands import SUBMIT_MS, Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.kernel import Kernel, Resource
from softshadows.gpu.layout import F32, U32, Struct, Vec3f, dtype, pack
from softshadows.gpu.upload import SceneBuffers
from softshadows.passes.bvh.sah import Shape, shape_by_area
from softshadows.passes.gbuffer.gbuffer import SCENE_STRUCTS
from softshadows.scene.clusters import triangle_boxes
from softshadows.scene.geometry import Geometry

_HERE = Path(__file__).parent
_USAGE = wgpu.BufferUsage
FAN = 4
"""Boxes below each box of the pyramid (refit.wgsl)."""
INVOCATIONS = 64
MOST_GROUPS = 65535
"""WebGPU: workgroups along one dimension of a dispatch."""
GRID_CELLS = 65535.0
GRID_MARGIN = 2.0
"""Cells kept free at either end, for what rounding outwards adds."""
MOST_TRIANGLES = 1 << 28
"""As many as a leaf's link can name (tree_node.wgsl)."""
LEAF = 0x80000000
LEAF_COUNT_SHIFT = 28
TRIANGLE_BYTES = 48
CUT_SHORT = (
    "rays: the device ended some walks through the scene's tree before their end, so that light may show where there "
    "is shadow. Render fewer samples, or use visibility='map'."
)
"""A frame's warning: software drivers bound the rounds of a shader's loops."""
CUTOUT_BUFFERS = 14
"""Storage buffers of a stage that looks at alpha masks: five of the scene's, two of the tree's, up to seven of the
technique's."""
RAYS_AT_ONCE = (16, 64)
"""Of a pixel in one dispatch. At least, since most pixels ask for few; at most, since software drivers bound the rounds
of an invocation's loops: 65 535 of llvmpipe's, of which 64 rays rarely take 2 000."""


def rays_at_once(gpu: Gpu, size: tuple[int, int]) -> int:
    """How many rays of every pixel fill a submit, within RAYS_AT_ONCE."""
    return int(np.clip(SUBMIT_MS * gpu.rays_per_ms / (size[0] * size[1]), *RAYS_AT_ONCE))


class TreeGrid(Struct):
    """The grid that a tree's boxes lie on, its counts, and how far the scene reaches from its middle
    (occluded.wgsl)."""

    low_ws: Vec3f
    triangle_count: U32
    cells_per_metre: Vec3f
    node_count: U32
    extent: F32
    diagonal: F32


TREE_STRUCTS = (TreeGrid, *SCENE_STRUCTS)


class Bvh:
    """The tree of one SceneBuffers. `encode` brings it up to date; `resources` are for bind group 1 of those who walk
    it.

    Raises DeviceError where the adapter cannot bind the scene's triangles at once.
    """

    def __init__(self, scene: SceneBuffers) -> None:
        gpu, geometry = scene.gpu, scene.geometry
        self._gpu, self._scene = gpu, scene
        self._fitted: Geometry | None = None
        count = len(geometry.triangles)
        if count > MOST_TRIANGLES:
            raise DeviceError(f"rays can walk through {MOST_TRIANGLES} triangles; the scene has {count}.")
        most = gpu.limit("max-storage-buffers-per-shader-stage")
        if self.has_cutouts and most < CUTOUT_BUFFERS:
            raise DeviceError(
                f"rays through surfaces with alpha masks read {CUTOUT_BUFFERS} storage buffers in one shader stage; "
                f"this device allows {most}. Use visibility='map', or profile 'full' on an adapter that allows more."
            )
        low, high, _ = triangle_boxes(geometry)
        shape = shape_by_area(low, high)
        self.bytes = 0
        self._node_count = len(shape.first) if count else 0
        self._levels = _pyramid_levels(count)
        self.grid = self._buffer(dtype(TreeGrid).itemsize, _USAGE.UNIFORM, "the tree's grid")
        self.nodes = self._buffer(16 * self._node_count, _USAGE.STORAGE | _USAGE.COPY_SRC, "the tree of the triangles")
        self.triangles = self._buffer(TRIANGLE_BYTES * count, _USAGE.STORAGE, "the tree's triangles")
        self._order = self._buffer(4 * count, _USAGE.STORAGE, "the order of the tree's triangles")
        self._shapes = self._buffer(16 * self._node_count, _USAGE.STORAGE, "the shape of the tree")
        self._pyramid = self._buffer(16 * sum(self._levels), _USAGE.STORAGE, "the boxes below the tree")
        if count:
            gpu.device.queue.write_buffer(self._order, 0, shape.order.astype(np.uint32))
            gpu.device.queue.write_buffer(self._shapes, 0, _records(shape))
        self._kernels = self._make_kernels()

    def _buffer(self, size: int, usage: int, what: str) -> wgpu.GPUBuffer:
        size = max(size, 256)
        self._gpu.check_buffer(size, what)
        self.bytes += size
        return self._gpu.device.create_buffer(size=size, usage=usage | _USAGE.COPY_DST)

    def _make_kernels(self) -> list[tuple[Kernel, int]]:
        """The steps of a refit, each with how many boxes it finds."""
        scene, pyramid = self._scene, {0: self.grid, 3: self._pyramid}

        def kernel(entry: str, groups: Mapping[int, Mapping[int, Resource]], **constants: float) -> Kernel:
            return Kernel(self._gpu, _HERE / "refit.wgsl", entry, TREE_STRUCTS, groups, constants)

        gathered = {**pyramid, 1: self._order, 2: self.triangles}
        gather = kernel("cs_gather", {0: gathered, 1: {0: scene.positions, 1: scene.indices}})
        reduce = [kernel("cs_reduce", {0: pyramid}, level=level) for level in range(1, len(self._levels))]
        bound = kernel("cs_bound", {0: {**pyramid, 4: self._shapes, 5: self.nodes}})
        return list(zip([gather, *reduce, bound], [*self._levels, self._node_count], strict=True))

    @property
    def has_cutouts(self) -> bool:
        """Has the scene triangles with an alpha mask?"""
        return self._scene.triangle_count > self._scene.opaque_count

    @property
    def resources(self) -> dict[int, Resource]:
        """What occluded.wgsl binds in group 1, and cutouts.wgsl where the scene has any."""
        own: dict[int, Resource] = {7: self.grid, 8: self.nodes, 9: self.triangles}
        if not self.has_cutouts:
            return own
        scene = self._scene
        buffers = (scene.indices, scene.attributes, scene.faces, scene.materials, scene.textures)
        return {**own, **dict(enumerate(buffers, start=1)), 6: scene.pages.create_view(dimension="2d-array")}

    @property
    def stand_ins(self) -> dict[str, str]:
        """For shaders that include occluded.wgsl: without alpha masks, nothing is read to find them."""
        return {} if self.has_cutouts else {"cutouts.wgsl": "no_cutouts.wgsl"}

    def bind(self) -> tuple[wgpu.GPUBindGroupLayout, wgpu.GPUBindGroup]:
        """Bind group 1 of passes that declare their layouts."""
        layouts, entries = [], []
        for binding, resource in self.resources.items():
            entry: dict = {"binding": binding, "visibility": wgpu.ShaderStage.COMPUTE}
            if isinstance(resource, wgpu.GPUBuffer):
                entry["buffer"] = {"type": "uniform" if resource is self.grid else "read-only-storage"}
                entries.append({"binding": binding, "resource": {"buffer": resource}})
            else:
                entry["texture"] = {"sample_type": "unfilterable-float", "view_dimension": "2d-array"}
                entries.append({"binding": binding, "resource": resource})
            layouts.append(entry)
        layout = self._gpu.device.create_bind_group_layout(entries=layouts)
        return layout, self._gpu.device.create_bind_group(layout=layout, entries=entries)

    def encode(self, commands: Commands) -> None:
        """Fit the boxes to where the triangles are now, unless they have not moved since the last time."""
        geometry = self._scene.geometry
        if geometry is self._fitted:
            return
        self._fitted = geometry
        self._gpu.device.queue.write_buffer(self.grid, 0, pack(self._grid(geometry)))
        with commands.compute("tree") as compute:
            for kernel, count in self._kernels if self._node_count else ():
                kernel.begin(compute)
                compute.dispatch_workgroups(*groups_of(count))

    def _grid(self, geometry: Geometry) -> TreeGrid:
        low, high = geometry.bounds
        cell = np.maximum(high - low, 1e-6 * max(geometry.diagonal, 1e-6)) / (GRID_CELLS - 2.0 * GRID_MARGIN)
        return TreeGrid(
            low_ws=tuple(low - GRID_MARGIN * cell),
            triangle_count=len(geometry.triangles),
            cells_per_metre=tuple(1.0 / cell),
            node_count=self._node_count,
            extent=geometry.extent,
            diagonal=geometry.diagonal,
        )


def tree_of(scene: SceneBuffers) -> Bvh:
    """The scene's tree: built when somebody first asks for it, and kept as long as the scene."""
    if scene.tree is None:
        scene.tree = Bvh(scene)
    return scene.tree


def groups_of(count: int) -> tuple[int, int]:
    """Workgroups along x and y that hold `count` invocations."""
    groups = max(-(-count // INVOCATIONS), 1)
    across = min(groups, MOST_GROUPS)
    return across, -(-groups // across)


def _pyramid_levels(count: int) -> list[int]:
    """Boxes in each level of the pyramid, from one per triangle to one."""
    levels = [count]
    while levels[-1] > 1:
        levels.append(-(-levels[-1] // FAN))
    return levels


def _records(shape: Shape) -> npt.NDArray[np.uint32]:
    """(n, 4) uint32: first, end and link of every node (refit.wgsl)."""
    leaf = LEAF | (shape.end - shape.first - 1) << LEAF_COUNT_SHIFT | shape.first
    link = np.where(shape.is_leaf, leaf, shape.skip)
    return np.stack([shape.first, shape.end, link, np.zeros_like(link)], axis=1).astype(np.uint32)
