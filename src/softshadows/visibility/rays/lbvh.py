"""A tree built on the GPU: along a space-filling curve, whose bits say how it parts, with leaves by surface area.

    lbvh.wgsl    where triangles lie along the curve, and once they are sorted the tree's shape
    sort.wgsl    the sort between
    merge.wgsl   larger leaves, once there are boxes

All is encoded at once: how many nodes remain when leaves have grown, only the GPU knows, and copies to where the walk
looks for it. Such a tree takes less time to build than one by surface area, and more to walk
(docs/decisions/0017-rays.md).
"""

from __future__ import annotations

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.layout import U32, Struct
from softshadows.gpu.program import Program, Resource
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.visibility.rays.grid import NODE_COUNT_OFFSET, groups_of
from softshadows.visibility.rays.sah import LARGE, NODE_COST

DIGITS = constant("visibility/rays/sort.wgsl", "DIGITS")
"""Values of a pass's digit, eight bits."""
PASSES = 6
"""Passes over codes of 46 bits; an even number, after which the list is where it was."""
BLOCK = constant("visibility/rays/inclusive_scan.wgsl", "BLOCK")
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
        self._remaining_before = self._gpu.storage_buffer(4 * (blocks + 1), "the counts of the tree's nodes")
        self.bytes = self._remaining_before.size
        self._make_programs(order, scratch)

    @staticmethod
    def scratch_bytes(triangles: int) -> int:
        """Codes, and either a list and counts or parents and ranges: lbvh_scratch.wgsl."""
        counts = DIGITS * (-(-triangles // BLOCK) + 1)
        return 4 * max(6 * triangles, 3 * triangles + counts)

    def _make_programs(self, order: wgpu.GPUBuffer, scratch: wgpu.GPUBuffer) -> None:
        building: dict[str, Resource] = {
            "tree": self._grid,
            "scratch": scratch,
            "order": order,
            "shapes": self._shapes,
            "vertex_positions_ws": self._scene.positions,
            "triangle_indices": self._scene.indices,
        }
        sorting: dict[str, Resource] = {"tree": self._grid, "scratch": scratch, "order": order}
        merging: dict[str, Resource] = {
            "tree": self._grid,
            "shapes": self._shapes,
            "nodes": self._nodes,
            "remaining_before": self._remaining_before,
        }

        def program(file: str, entry: str, resources: dict[str, Resource], **constants: float) -> Program:
            return Program(self._gpu, f"visibility/rays/{file}", entry, resources, constants=constants)

        self._code = program("lbvh.wgsl", "cs_code", building, LARGE=LARGE)
        self._split, self._number = (program("lbvh.wgsl", entry, building) for entry in ("cs_split", "cs_number_nodes"))
        self._sort_count, self._scan_blocks, self._scan_digits, self._sort_move = (
            program("sort.wgsl", entry, sorting)
            for entry in ("cs_count", "cs_scan_blocks", "cs_scan_digits", "cs_move")
        )
        passes = [self._gpu.uniform(SortPass(digit=digit)) for digit in range(PASSES)]
        self._passes = [(self._sort_count.bind(sort=each), self._sort_move.bind(sort=each)) for each in passes]
        self._collapse = program("merge.wgsl", "cs_collapse", merging, NODE_COST=NODE_COST)
        self._count_remaining, self._sum, self._compact = (
            program("merge.wgsl", entry, merging) for entry in ("cs_count_remaining", "cs_sum", "cs_compact")
        )

    def encode_split(self, commands: Commands) -> None:
        """Order and shape of the tree with a triangle in each leaf, 2t - 1 nodes."""
        pass_ms = self._count / self._gpu.budget.triangles_per_ms
        triangles, nodes, blocks = groups_of(self._count), groups_of(self._node_count), groups_of(self._count, BLOCK)
        with commands.compute("tree") as compute:
            self._code.dispatch(compute, triangles)
        commands.account(pass_ms)
        for count, move in self._passes:
            with commands.compute("tree") as compute:
                self._sort_count.dispatch(compute, blocks, count)
                self._scan_blocks.dispatch(compute, (DIGITS,))
                self._scan_digits.dispatch(compute, (1,))
                self._sort_move.dispatch(compute, blocks, move)
            commands.account(pass_ms)
        with commands.compute("tree") as compute:
            self._split.dispatch(compute, triangles)
            self._number.dispatch(compute, nodes)
        commands.account(2.0 * pass_ms)

    def encode_merge(self, commands: Commands) -> None:
        """The shape with larger leaves; `nodes` then hold no boxes."""
        nodes = groups_of(self._node_count)
        with commands.compute("tree") as compute:
            self._collapse.dispatch(compute, nodes)
            self._count_remaining.dispatch(compute, groups_of(self._node_count, BLOCK))
            self._sum.dispatch(compute, (1,))
            self._compact.dispatch(compute, nodes)
        encoder, remaining = commands.encoder, self._remaining_before.size - 4
        encoder.copy_buffer_to_buffer(self._nodes, 0, self._shapes, 0, 16 * self._node_count)
        encoder.copy_buffer_to_buffer(self._remaining_before, remaining, self._grid, NODE_COUNT_OFFSET, 4)
        commands.account(2.0 * self._count / self._gpu.budget.triangles_per_ms)
