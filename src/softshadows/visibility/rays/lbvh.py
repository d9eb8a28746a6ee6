"""A tree built on the GPU: along a space-filling curve, whose bits say how it parts, with leaves by surface area.

    lbvh.wgsl    where triangles lie along the curve, and once they are sorted the tree's shape
    sort.wgsl    the sort between
    merge.wgsl   larger leaves, once there are boxes

All is encoded at once: how many nodes remain when leaves have grown, only the GPU knows, and copies to where the walk
looks for it. Such a tree takes less time to build than one by surface area, and more to walk
(docs/decisions/0017-rays.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.kernel import Kernel, Resource
from softshadows.gpu.layout import U32, Struct, pack
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.visibility.rays.grid import NODE_COUNT_OFFSET, groups_of
from softshadows.visibility.rays.sah import LARGE, NODE_COST

_HERE = Path(__file__).parent
DIGITS = 256
"""Of a pass of the sort: eight bits (sort.wgsl)."""
PASSES = 6
"""Of codes with 46 bits; an even number, after which the list is where it was."""
BLOCK = 2048
"""Triangles of one workgroup of the sort, nodes of one of the merge."""


class SortPass(Struct):
    """Which of a code's six digits a pass sorts by, the lowest first."""

    digit: U32


class Lbvh:
    """Builds the shape of a scene's tree.

    Between `encode_split`, which leaves a triangle in each leaf, and `encode_merge`, `nodes` are to be given boxes.
    `scratch` has `scratch_bytes`, which serve the first alone.
    """

    def __init__(
        self,
        scene: SceneBuffers,
        *,
        grid: wgpu.GPUBuffer,
        order: wgpu.GPUBuffer,
        shapes: wgpu.GPUBuffer,
        nodes: wgpu.GPUBuffer,
        scratch: wgpu.GPUBuffer,
    ) -> None:
        self._gpu, self._scene = scene.gpu, scene
        self._grid, self._shapes, self._nodes = grid, shapes, nodes
        self._count, self._node_count = scene.triangle_count, 2 * scene.triangle_count - 1
        blocks = -(-self._node_count // BLOCK)
        self._stay_before = self._gpu.storage_buffer(4 * (blocks + 1), "the counts of the tree's nodes")
        self.bytes = self._stay_before.size
        self._make_kernels(order, scratch)

    @staticmethod
    def scratch_bytes(triangles: int) -> int:
        """Codes, and either a list and counts or parents and ranges: lbvh_scratch.wgsl."""
        counts = DIGITS * (-(-triangles // BLOCK) + 1)
        return 4 * max(6 * triangles, 3 * triangles + counts)

    def _make_kernels(self, order: wgpu.GPUBuffer, scratch: wgpu.GPUBuffer) -> None:
        shared: dict[int, Resource] = {0: self._grid, 1: scratch}
        listed: dict[int, Resource] = {**shared, 3: order}
        scene: dict[int, Resource] = {0: self._scene.positions, 1: self._scene.indices}

        def kernel(file: str, entry: str, groups: Mapping[int, Mapping[int, Resource]], **constants: float) -> Kernel:
            return Kernel(self._gpu, _HERE / file, entry, groups, constants)

        self._code = kernel("lbvh.wgsl", "cs_code", {0: listed, 1: scene}, LARGE=LARGE)
        self._split = kernel("lbvh.wgsl", "cs_split", {0: listed})
        self._number = kernel("lbvh.wgsl", "cs_number", {0: {**shared, 4: self._shapes}})

        usage = wgpu.BufferUsage.UNIFORM
        passes = [
            self._gpu.device.create_buffer_with_data(data=pack(SortPass(digit=digit)), usage=usage)
            for digit in range(PASSES)
        ]
        self._scans = [kernel("sort.wgsl", entry, {0: shared}) for entry in ("cs_scan_blocks", "cs_scan_digits")]
        self._sort_count, self._sort_move = (kernel("sort.wgsl", entry, {}) for entry in ("cs_count", "cs_move"))
        self._passes = [
            tuple(kernel.bind(0, {**listed, 2: each}) for kernel in (self._sort_count, self._sort_move))
            for each in passes
        ]

        shapes: dict[int, Resource] = {0: self._grid, 1: self._shapes}
        nodes: dict[int, Resource] = {**shapes, 2: self._nodes}
        sums: dict[int, Resource] = {3: self._stay_before}
        self._judge = kernel("merge.wgsl", "cs_judge", {0: nodes}, NODE_COST=NODE_COST)
        self._stay = kernel("merge.wgsl", "cs_stay", {0: {**nodes, **sums}})
        self._sum = kernel("merge.wgsl", "cs_sum", {0: sums})
        self._close_up = kernel("merge.wgsl", "cs_close_up", {0: {**nodes, **sums}})

    def encode_split(self, commands: Commands) -> None:
        """Order and shape of the tree with a triangle in each leaf, 2t - 1 nodes."""
        pass_ms = self._count / self._gpu.triangles_per_ms
        triangles, nodes, blocks = groups_of(self._count), groups_of(self._node_count), groups_of(self._count, BLOCK)
        with commands.compute("tree") as compute:
            _run(compute, self._code, triangles)
        commands.account(pass_ms)
        for count, move in self._passes:
            with commands.compute("tree") as compute:
                _run(compute, self._sort_count, blocks, count)
                _run(compute, self._scans[0], (DIGITS, 1))
                _run(compute, self._scans[1], (1, 1))
                _run(compute, self._sort_move, blocks, move)
            commands.account(pass_ms)
        with commands.compute("tree") as compute:
            _run(compute, self._split, triangles)
            _run(compute, self._number, nodes)
        commands.account(2.0 * pass_ms)

    def encode_merge(self, commands: Commands) -> None:
        """The shape with larger leaves; `nodes` then hold no boxes."""
        nodes = groups_of(self._node_count)
        with commands.compute("tree") as compute:
            _run(compute, self._judge, nodes)
            _run(compute, self._stay, groups_of(self._node_count, BLOCK))
            _run(compute, self._sum, (1, 1))
            _run(compute, self._close_up, nodes)
        encoder, remaining = commands.encoder, self._stay_before.size - 4
        encoder.copy_buffer_to_buffer(self._nodes, 0, self._shapes, 0, 16 * self._node_count)
        encoder.copy_buffer_to_buffer(self._stay_before, remaining, self._grid, NODE_COUNT_OFFSET, 4)
        commands.account(2.0 * self._count / self._gpu.triangles_per_ms)


def _run(
    compute: wgpu.GPUComputePassEncoder,
    kernel: Kernel,
    groups: tuple[int, int],
    bindings: wgpu.GPUBindGroup | None = None,
) -> None:
    kernel.begin(compute, {} if bindings is None else {0: bindings})
    compute.dispatch_workgroups(*groups)
