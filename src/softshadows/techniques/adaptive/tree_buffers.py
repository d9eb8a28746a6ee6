"""The trees of a light and what pixels remember of it, on the GPU (tree.wgsl)."""

from __future__ import annotations

import wgpu

from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.program import Resource
from softshadows.lights.lattice import Lattice
from softshadows.techniques.adaptive.structs import TreeShape
from softshadows.visibility.receivers import BOX_EDGE

_TREE = "techniques/adaptive/tree.wgsl"
TILE = constant(_TREE, "TILE")
"""Pixels along a tile's side."""
assert TILE == BOX_EDGE, "a tile's receivers are those of one box that windows are fitted to"
QUADRANTS, CELLS_PER_ROW = constant(_TREE, "QUADRANTS"), constant(_TREE, "CELLS_PER_ROW")
DEEPEST_CELLS = constant("techniques/adaptive/probes.wgsl", "DEEPEST_CELLS")
CONTROL_WORDS = 4 * constant(_TREE, "MOST_LEVELS") + constant(_TREE, "MOST_ROWS") + constant(_TREE, "MOST_SAMPLES") + 2
"""Words of struct Control, before its lists of tiles."""
DISPATCH_BYTES = 16
"""Bytes of an indirect dispatch's arguments, in array<vec4u>."""


def tiles_of(size: tuple[int, int]) -> tuple[int, int]:
    """Tiles across and down an image."""
    return -(-size[0] // TILE), -(-size[1] // TILE)


class TreeBuffers:
    """Buffers of one light at a time; `clear` before the next.

    `visibility_bits` holds `mask_sets` bits for each sample and pixel.
    """

    def __init__(self, gpu: Gpu, lattice: Lattice, shape: TreeShape, mask_sets: int) -> None:
        columns, rows = tiles_of(shape.image_size)
        tiles = columns * rows
        trees = 1 if shape.is_global else tiles
        cell_rows = trees * shape.refined_rows

        def buffer(words: int, usage: int = 0) -> wgpu.GPUBuffer:
            usage |= wgpu.BufferUsage.STORAGE
            return gpu.buffer(4 * max(words, 4), usage, "the look-ups that adaptive sampling remembers")

        self.shape = gpu.uniform(shape)
        self.trees = buffer(trees * lattice.rows + cell_rows)
        self.failures = buffer(cell_rows * QUADRANTS + tiles)
        self.visibility_bits = buffer(mask_sets * tiles * (-(-lattice.rows // 2) + 1) * TILE * TILE)
        self.control = buffer(CONTROL_WORDS + (lattice.depth + 1) * tiles)
        self.dispatches = buffer(8 * (lattice.depth + 1), wgpu.BufferUsage.INDIRECT)
        self.probes = buffer(tiles * 2 * DEEPEST_CELLS if shape.has_probes else 0)
        self.counts = buffer(cell_rows * CELLS_PER_ROW if shape.threshold else 0)

    @property
    def resources(self) -> dict[str, Resource]:
        """What the folder's shaders declare of them, by name."""
        return dict(vars(self))

    @property
    def bytes(self) -> int:
        return sum(buffer.size for buffer in vars(self).values())

    def clear(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Forget the light before."""
        encoder.clear_buffer(self.control, 0, 4 * CONTROL_WORDS)
        for buffer in (self.failures, self.counts, self.probes):
            encoder.clear_buffer(buffer)

    @staticmethod
    def tile_dispatch(level: int) -> int:
        """Where in `dispatches` the arguments lie for a level's tiles."""
        return 2 * level * DISPATCH_BYTES

    @staticmethod
    def sample_dispatch(level: int) -> int:
        """Where they lie for the samples that the level adds."""
        return (2 * level + 1) * DISPATCH_BYTES
