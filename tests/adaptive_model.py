"""Adaptive light sampling once more, in numpy and cell by cell: what the trees on the GPU have to be.

Written from the paper's rules, not from the shaders: no rows of bits, no lists, no atomics. It takes the look-ups that
the GPU remembers, since those are the business of the shadow maps, and decides everything else again.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

import softshadows as ss
from softshadows.techniques.adaptive.lattice import Lattice
from softshadows.techniques.adaptive.sampling import TILE, AdaptiveSampling

Bools = npt.NDArray[np.bool_]
Cell = tuple[int, int, int]
"""Level, row and column."""

RING = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


@dataclass
class Tree:
    """For every tile of the picture, (tiles down, tiles across): is the cell in its tree, and is it refined?"""

    present: dict[Cell, Bools] = field(default_factory=dict)
    refined: dict[Cell, Bools] = field(default_factory=dict)
    capped: Bools = field(default_factory=lambda: np.zeros((0, 0), bool))  # a cell of the deepest level fails

    def depth(self) -> int:
        """Of the deepest cell in any tile's tree."""
        return max((level for (level, _, _), tiles in self.present.items() if tiles.any()), default=0)

    def same_as(self, other: Tree) -> list[str]:
        """What differs, in words; empty if nothing does."""
        found = []
        for what in ("present", "refined"):
            mine, others = getattr(self, what), getattr(other, what)
            for cell in sorted(mine.keys() | others.keys()):
                wrong = np.argwhere(mine[cell] != others[cell])
                if len(wrong):
                    found.append(f"{what} {cell}: {len(wrong)} tiles, first {tuple(wrong[0])}")
        return found


class Gpu:
    """What an AdaptiveSampling's buffers hold after a frame, for the light that took the last turn.

    visible (height, width, rows, columns): the remembered look-ups, true of samples that the pixel sees; requested
    (tiles down, tiles across, rows, columns): the samples of each tile's tree.
    """

    def __init__(self, renderer: ss.Renderer, frame: ss.Frame, is_global: bool) -> None:
        self.sampling: AdaptiveSampling = renderer._pass._turns[-1][0]  # type: ignore[attr-defined]
        self.lattice: Lattice = self.sampling._lattice
        self.surface = frame.surface
        self.is_global = is_global
        height, width = frame.surface.shape
        self.tiles = (-(-height // TILE), -(-width // TILE))
        rows, columns = self.lattice.rows, self.lattice.columns
        masks = self.words("masks")[: self.tiles[0] * self.tiles[1] * rows * TILE * TILE]
        masks = masks.reshape(*self.tiles, rows, TILE, TILE).transpose(0, 3, 1, 4, 2)
        masks = masks.reshape(self.tiles[0] * TILE, self.tiles[1] * TILE, rows)[:height, :width]
        self.visible = bits(masks, columns)
        self.requested = bits(self._by_tree("requests", rows), columns)

    def words(self, buffer: str) -> npt.NDArray[np.uint32]:
        device = self.sampling._context.gpu.device
        return np.frombuffer(device.queue.read_buffer(self.sampling._buffers[buffer]), "<u4")

    def _by_tree(self, buffer: str, rows: int) -> npt.NDArray[np.uint32]:
        trees = (1, 1) if self.is_global else self.tiles
        words = self.words(buffer)[: trees[0] * trees[1] * rows].reshape(*trees, rows)
        return np.broadcast_to(words, (*self.tiles, rows))

    def tree(self) -> Tree:
        """The trees as the GPU left them: refined cells, and their children."""
        lattice, tree = self.lattice, Tree()
        levels = range(lattice.depth)
        refined_rows = sum(rows_of(lattice, level) for level in levels)
        words = bits(self._by_tree("refined", refined_rows), lattice.columns) if refined_rows else None
        tree.present[0, 0, 0] = self.requested[:, :, 0, 0]
        first = 0
        for level in levels:
            for row in range(rows_of(lattice, level)):
                for column in range(columns_of(lattice, level)):
                    assert words is not None
                    refined = words[:, :, first + row, column * lattice.spacing(level)]
                    tree.refined[level, row, column] = refined
                    for child in children(lattice, (level, row, column)):
                        tree.present[child] = refined
            first += rows_of(lattice, level)
        return tree


def bits(words: npt.NDArray[np.uint32], count: int) -> Bools:
    """(..., count): the words' lowest bits."""
    return (words[..., None] >> np.arange(count, dtype=np.uint32) & 1).astype(bool)


def rows_of(lattice: Lattice, level: int) -> int:
    return 1 << level if lattice.has_rows else 1


def columns_of(lattice: Lattice, level: int) -> int:
    return 1 << level if lattice.has_columns else 1


def children(lattice: Lattice, cell: Cell) -> list[Cell]:
    level, row, column = cell
    rows = [2 * row, 2 * row + 1] if lattice.has_rows else [0]
    columns = [2 * column, 2 * column + 1] if lattice.has_columns else [0]
    return [(level + 1, r, c) for r in rows for c in columns]


def corners(lattice: Lattice, cell: Cell) -> list[tuple[int, int]]:
    """(row, column) of the samples at a cell's corners: four, two on a line, one on a point."""
    level, row, column = cell
    spacing = lattice.spacing(level)
    rows = [row * spacing, (row + 1) * spacing] if lattice.has_rows else [0]
    columns = [column * spacing, (column + 1) * spacing] if lattice.has_columns else [0]
    return [(r, c) for r in rows for c in columns]


def failing_texels(gpu: Gpu, cell: Cell, present: Bools, step: int) -> Bools:
    """[Schwaerzler2012 §3.3.3] (height, width): texels of the comparison that see some of the cell's corners, but not
    all, and none of whose eight neighbours sees another number of them.

    The comparison's texels are `step` pixels apart. Only texels of surfaces, in tiles that have the cell, count, both
    as the texel and as its neighbour.
    """
    at = corners(gpu.lattice, cell)
    number = sum(gpu.visible[:, :, r, c].astype(int) for r, c in at)
    counts = (gpu.surface & by_pixel(present, gpu.surface.shape))[::step, ::step]
    texels = np.where(counts, number[::step, ::step], -1)
    padded = np.pad(texels, 1, constant_values=-1)
    height, width = texels.shape
    fails = (texels > 0) & (texels < len(at))
    for dy, dx in RING:
        beside = padded[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]
        fails &= (beside < 0) | (beside == texels)
    whole = np.zeros(gpu.surface.shape, bool)
    whole[::step, ::step] = fails
    return whole


def by_pixel(tiles: Bools, shape: tuple[int, ...]) -> Bools:
    return tiles.repeat(TILE, axis=0).repeat(TILE, axis=1)[: shape[0], : shape[1]]


def tiles_with(texels: Bools, tiles: tuple[int, int], beyond: int) -> Bools:
    """Which tiles hold one of the texels, or have one within `beyond` pixels around them?"""
    padded = np.zeros((tiles[0] * TILE + 2 * beyond, tiles[1] * TILE + 2 * beyond), bool)
    padded[beyond : beyond + texels.shape[0], beyond : beyond + texels.shape[1]] = texels
    found = np.zeros(tiles, bool)
    for y, x in np.ndindex(tiles):
        found[y, x] = padded[y * TILE : (y + 1) * TILE + 2 * beyond, x * TILE : (x + 1) * TILE + 2 * beyond].any()
    return found


def grow(gpu: Gpu, step: int = 1) -> Tree:
    """The trees that the paper's test grows from the root, level by level.

    One tree for all tiles, or one each: then a cell also fails where it fails within half a tile around. Tiles in which
    nothing is to be found out have none, which the GPU says.
    """
    lattice, tree = gpu.lattice, Tree()
    has_surface = tiles_with(gpu.surface, gpu.tiles, 0)
    tree.capped = np.zeros(gpu.tiles, bool)
    tree.present[0, 0, 0] = np.ones(gpu.tiles, bool) if gpu.is_global else gpu.requested[:, :, 0, 0]
    for level in range(lattice.depth + 1):
        for row in range(rows_of(lattice, level)):
            for column in range(columns_of(lattice, level)):
                cell = (level, row, column)
                present = tree.present[cell]
                fails = failing_texels(gpu, cell, present, step) if present.any() else np.zeros_like(gpu.surface)
                if level == lattice.depth:
                    tree.capped |= tiles_with(fails, gpu.tiles, 0)
                    continue
                refined = present & (fails.any() if gpu.is_global else tiles_with(fails, gpu.tiles, TILE // 2))
                tree.refined[cell] = refined
                for child in children(lattice, cell):
                    tree.present[child] = refined
    assert gpu.is_global or not (tree.present[0, 0, 0] & ~has_surface).any()
    return tree


def requested(lattice: Lattice, tree: Tree) -> Bools:
    """(tiles down, tiles across, rows, columns): the samples at the corners of each tree's cells."""
    found = np.zeros((*tree.present[0, 0, 0].shape, lattice.rows, lattice.columns), bool)
    for cell, present in tree.present.items():
        for row, column in corners(lattice, cell):
            found[:, :, row, column] |= present
    return found


def weights(lattice: Lattice, tree: Tree, rule: str) -> npt.NDArray[np.float64]:
    """(tiles down, tiles across, rows, columns): what each sample counts, in all 1.

    "area": each leaf gives its area in equal parts to its corners. "paper": equation 3, where the deepest leaf at the
    sample counts, and the sum is normalised.
    """
    found = np.zeros((*tree.present[0, 0, 0].shape, lattice.rows, lattice.columns))
    for cell, present in sorted(tree.present.items()):
        level = cell[0]
        leaf = present & ~tree.refined.get(cell, np.zeros_like(present))
        at = corners(lattice, cell)
        for row, column in at:
            if rule == "area":
                found[:, :, row, column] += leaf * 0.5 ** (level * lattice.dimensions) / len(at)
            else:  # deeper levels come later
                equation_3 = 1.0 / (2.0**level + 1.0) ** lattice.dimensions
                found[:, :, row, column] = np.where(leaf, equation_3, found[:, :, row, column])
    total = found.sum(axis=(2, 3), keepdims=True)
    if rule == "area":
        assert np.isin(np.round(total, 12), (0.0, 1.0)).all(), "a tree's leaves tile the light"
    return found / np.where(total > 0.0, total, 1.0)


def visibility(gpu: Gpu, tree: Tree, rule: str) -> npt.NDArray[np.float64]:
    """(height, width): the weighted share of visible samples; NaN where there is no surface or the tile has no tree."""
    by_tile = weights(gpu.lattice, tree, rule)
    height, width = gpu.surface.shape
    each = by_tile.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width]
    found = (each * gpu.visible).sum(axis=(2, 3))
    return np.where(gpu.surface & by_pixel(tree.present[0, 0, 0], gpu.surface.shape), found, np.nan)


def lookups(gpu: Gpu, tree: Tree) -> int:
    """Of all pixels with a surface: as many as their tile's tree has samples."""
    per_tile = requested(gpu.lattice, tree).sum(axis=(2, 3))
    return int((by_pixel(per_tile, gpu.surface.shape) * gpu.surface).sum())


def maps(gpu: Gpu, tree: Tree) -> int:
    """Samples that some tile with a surface requests."""
    has_surface = tiles_with(gpu.surface, gpu.tiles, 0)
    return int((requested(gpu.lattice, tree) & has_surface[:, :, None, None]).any(axis=(0, 1)).sum())
