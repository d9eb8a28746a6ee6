"""Trees built on the GPU: triangles sorted along a space-filling curve, whose bits say how the tree parts them.

    lbvh.wgsl    codes, and from the sorted codes the tree's shape
    sort.wgsl    the sort between

The CPU knows all counts, so that everything is encoded at once. A tree of this kind is built faster than one by surface
area, and is walked more slowly: docs/decisions/0015-rays.md.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.kernel import Kernel, Resource
from softshadows.gpu.layout import U32, Struct, pack
from softshadows.gpu.upload import SceneBuffers
from softshadows.passes.bvh.grid import TREE_STRUCTS, groups_of
from softshadows.passes.bvh.parts import LBVH_LEAF, Build, lbvh_node_count

_HERE = Path(__file__).parent
DIGITS = 256
"""Of a pass of the sort: eight bits (sort.wgsl)."""
PASSES = 6
"""Of codes with 48 bits; an even number, after which the list is where it was."""
BLOCK = 2048
"""Triangles of one workgroup of the sort (sort.wgsl)."""


class BuildStep(Struct):
    """A Build, a pass of its sort, and where in the scratch buffer the other list and the counts begin."""

    first_place: U32
    count: U32
    first_node: U32
    digit: U32
    list_start: U32
    counts_start: U32


STRUCTS = (BuildStep, *TREE_STRUCTS)


class Lbvh:
    """Builds trees over triangles that `order` lists, and writes their records to `shapes`.

    `scratch` holds at least `scratch_bytes` and nothing of it is kept: codes by triangle, two words each; from there
    on a list and counts while it sorts, parents and ranges of the tree's nodes afterwards.
    """

    def __init__(
        self,
        scene: SceneBuffers,
        grid: wgpu.GPUBuffer,
        order: wgpu.GPUBuffer,
        shapes: wgpu.GPUBuffer,
        scratch: wgpu.GPUBuffer,
    ) -> None:
        self._gpu, self._scene = scene.gpu, scene
        self._buffers: dict[int, Resource] = {1: order, 2: scratch, 3: shapes, 4: grid}

    @staticmethod
    def scratch_bytes(triangles: int) -> int:
        """For trees over up to so many triangles, in a scene of as many."""
        counts = DIGITS * (-(-triangles // BLOCK) + 1)
        parents_and_ranges = 2 * (lbvh_node_count(triangles) + 1)
        return 4 * (2 * triangles + max(triangles + counts, parents_and_ranges))

    def encode(self, commands: Commands, build: Build) -> None:
        """Build one tree."""
        steps = [self._step(build, digit) for digit in range(PASSES)]
        pass_ms = build.count / self._gpu.triangles_per_ms
        per_triangle, per_node = groups_of(build.count), groups_of(lbvh_node_count(build.count))
        with commands.compute("tree") as compute:
            self._run(compute, "cs_code", steps[0], per_triangle)
        for step in steps:
            with commands.compute("tree") as compute:
                blocks = groups_of(build.count, BLOCK)
                self._run(compute, "cs_count", step, blocks)
                self._run(compute, "cs_scan_blocks", step, (DIGITS, 1))
                self._run(compute, "cs_scan_digits", step, (1, 1))
                self._run(compute, "cs_move", step, blocks)
            commands.account(pass_ms)
        with commands.compute("tree") as compute:
            self._run(compute, "cs_split", steps[0], per_node)
            self._run(compute, "cs_number", steps[0], per_node)
        commands.account(pass_ms)

    def _step(self, build: Build, digit: int) -> wgpu.GPUBuffer:
        codes = 2 * self._scene.triangle_count
        step = BuildStep(
            first_place=build.first_place,
            count=build.count,
            first_node=build.first_node,
            digit=digit,
            list_start=codes,
            counts_start=codes + build.count,
        )
        return self._gpu.device.create_buffer_with_data(data=pack(step), usage=wgpu.BufferUsage.UNIFORM)

    def _run(
        self, compute: wgpu.GPUComputePassEncoder, entry: str, step: wgpu.GPUBuffer, groups: tuple[int, int]
    ) -> None:
        kernel = self._kernels[entry]
        used = {binding: self._buffers[binding] for binding in BINDINGS[entry]}
        kernel.begin(compute, {0: kernel.bind(0, {0: step, **used})})
        compute.dispatch_workgroups(*groups)

    @cached_property
    def _kernels(self) -> dict[str, Kernel]:
        """By entry; compiled for the first build."""
        scene: dict[int, Resource] = {0: self._scene.positions, 1: self._scene.indices}
        return {
            entry: Kernel(
                self._gpu,
                _HERE / ("lbvh.wgsl" if entry in ("cs_code", "cs_split", "cs_number") else "sort.wgsl"),
                entry,
                STRUCTS,
                {1: scene} if entry == "cs_code" else {},
                {"LEAF_TRIANGLES": LBVH_LEAF} if entry in ("cs_split", "cs_number") else {},
            )
            for entry in BINDINGS
        }


BINDINGS = {
    "cs_code": (1, 2, 4),
    "cs_count": (1, 2),
    "cs_scan_blocks": (2,),
    "cs_scan_digits": (2,),
    "cs_move": (1, 2),
    "cs_split": (1, 2),
    "cs_number": (2, 3),
}
"""By entry: those of the buffers that it uses beside the step."""
