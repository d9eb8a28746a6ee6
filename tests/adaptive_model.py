"""Adaptive light sampling once more, in numpy and cell by cell: what the trees on the GPU have to be.

Written from the paper's rules, not from the shaders: no rows of bits, no lists, no atomics. It takes the look-ups that
the GPU remembers, since those are the business of the shadow maps, and decides everything else again.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

import softshadows as ss
from softshadows.lights.lattice import Lattice
from softshadows.techniques.adaptive.sampling import SURE_LEVELS, AdaptiveSampling
from softshadows.techniques.adaptive.tree_buffers import TILE

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
        """The level of the deepest cell in any tile's tree."""
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

    visible (height, width, rows, columns): the look-ups' bits, true of samples that the pixel sees; requested
    (tiles down, tiles across, rows, columns): the samples of each tile's tree.
    """

    def __init__(self, renderer: ss.Renderer, frame: ss.Frame, is_global: bool) -> None:
        self.sampling: AdaptiveSampling = renderer.passes.technique._by_light[-1][0]  # type: ignore[union-attr]
        self.lattice: Lattice = self.sampling._lattice
        self.surface = frame.surface
        self.is_global = is_global
        height, width = frame.surface.shape
        self.tiles = (-(-height // TILE), -(-width // TILE))
        rows, columns = self.lattice.rows, self.lattice.columns
        self.visible = bits(self._masks(rows)[:height, :width], columns)
        self.requested, self._refined = self._rows_of_trees()

    def _masks(self, rows: int) -> npt.NDArray[np.uint32]:
        """(pixels down, pixels across, rows): words whose bit x is sample x of the row.

        They come by tile: two rows of 16 samples to a word, then a word whose bit y is the 17th sample of row y.
        """
        pairs = (rows + 1) // 2
        words = self.words("visibility_bits")[: self.tiles[0] * self.tiles[1] * (pairs + 1) * TILE * TILE]
        words = words.reshape(*self.tiles, pairs + 1, TILE, TILE).transpose(0, 3, 1, 4, 2)
        words = words.reshape(self.tiles[0] * TILE, self.tiles[1] * TILE, pairs + 1)
        number = np.arange(rows, dtype=np.uint32)
        sixteen = words[..., number // 2] >> 16 * (number % 2) & 0xFFFF
        return sixteen | (words[..., pairs:] >> number & 1) << 16

    def words(self, buffer: str) -> npt.NDArray[np.uint32]:
        device = self.sampling._context.gpu.device
        return np.frombuffer(device.queue.read_buffer(getattr(self.sampling.buffers, buffer)), "<u4")

    def _rows_of_trees(self) -> tuple[Bools, Bools]:
        """(tiles down, tiles across, rows, columns): each tree's requested samples, and its rows of refined cells."""
        lattice, trees = self.lattice, (1, 1) if self.is_global else self.tiles
        count = lattice.rows + sum(rows_of(lattice, level) for level in range(lattice.depth))
        words = self.words("trees")[: trees[0] * trees[1] * count].reshape(*trees, count)
        rows = bits(np.broadcast_to(words, (*self.tiles, count)), lattice.columns)
        return rows[:, :, : lattice.rows], rows[:, :, lattice.rows :]

    def tree(self) -> Tree:
        """The trees as the GPU left them: refined cells, and their children."""
        lattice, tree = self.lattice, Tree()
        tree.present[0, 0, 0] = self.requested[:, :, 0, 0]
        first = 0
        for level in range(lattice.depth):
            for row in range(rows_of(lattice, level)):
                for column in range(columns_of(lattice, level)):
                    refined = self._refined[:, :, first + row, column * lattice.spacing(level)]
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


def number_of_corners(gpu: Gpu, cell: Cell, present: Bools, step: int) -> npt.NDArray[np.int_]:
    """[Schwaerzler2012 §3.3.3] For every texel of the comparison, how many of the cell's corners it sees.

    The comparison's texels are `step` pixels apart. Only texels of surfaces, in tiles that have the cell, count; others
    are -1.
    """
    number = sum(gpu.visible[:, :, r, c].astype(int) for r, c in corners(gpu.lattice, cell))
    counts = gpu.surface & by_pixel(present, gpu.surface.shape)
    return np.where(counts, number, -1)[::step, ::step]


def without_ring(texels: npt.NDArray[np.int_]) -> Bools:
    """[Schwaerzler2012 §3.3.3] Which texels have no neighbour, of those eight that count, with another number?"""
    padded = np.pad(texels, 1, constant_values=-1)
    height, width = texels.shape
    found = np.ones(texels.shape, bool)
    for dy, dx in RING:
        beside = padded[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]
        found &= (beside < 0) | (beside == texels)
    return found


def failing_texels(gpu: Gpu, cell: Cell, present: Bools, step: int) -> Bools:
    """(height, width): texels that see some of the cell's corners, but not all, and pass no test of their neighbours.

    In trees by tile, the sure levels do not ask the neighbours, but the deepest one always does: what fails there is
    reported, not refined.
    """
    texels = number_of_corners(gpu, cell, present, step)
    fails = (texels > 0) & (texels < len(corners(gpu.lattice, cell)))
    if gpu.is_global or cell[0] >= min(SURE_LEVELS, gpu.lattice.depth):
        fails &= without_ring(texels)
    whole = np.zeros(gpu.surface.shape, bool)
    whole[::step, ::step] = fails
    return whole


def by_pixel(tiles: Bools, shape: tuple[int, ...]) -> Bools:
    return tiles.repeat(TILE, axis=0).repeat(TILE, axis=1)[: shape[0], : shape[1]]


def count_by_tile(texels: Bools, tiles: tuple[int, int], beyond: int = 0) -> npt.NDArray[np.int_]:
    """(tiles down, tiles across): how many of the texels lie in a tile, or within `beyond` pixels around it."""
    padded = np.zeros((tiles[0] * TILE + 2 * beyond, tiles[1] * TILE + 2 * beyond), bool)
    padded[beyond : beyond + texels.shape[0], beyond : beyond + texels.shape[1]] = texels
    found = np.zeros(tiles, int)
    for y, x in np.ndindex(tiles):
        found[y, x] = padded[y * TILE : (y + 1) * TILE + 2 * beyond, x * TILE : (x + 1) * TILE + 2 * beyond].sum()
    return found


def needs_more(gpu: Gpu, cell: Cell, fails: Bools, threshold: int) -> Bools:
    """Which trees refine the cell, as far as they have it?

    One tree for all tiles: where more texels fail than may. One each: the root always, other cells by the tile's own
    texels, and on the sure levels also where a texel fails within half a tile around, in a tile of which more fail than
    may.
    """
    if gpu.is_global:
        return np.full(gpu.tiles, fails.sum() > threshold)
    if cell[0] == 0:
        return np.ones(gpu.tiles, bool)
    own = count_by_tile(fails, gpu.tiles)
    if cell[0] >= SURE_LEVELS:
        return own > threshold
    beyond = fails & by_pixel(own > threshold, fails.shape)
    return count_by_tile(beyond, gpu.tiles, TILE // 2) > 0


def grow(gpu: Gpu, step: int = 1, threshold: int = 0) -> Tree:
    """The trees that the paper's test grows from the root, level by level.

    Tiles in which nothing is to be found out have none, which the GPU says.
    """
    lattice, tree = gpu.lattice, Tree()
    has_surface = count_by_tile(gpu.surface, gpu.tiles) > 0
    tree.capped = np.zeros(gpu.tiles, bool)
    tree.present[0, 0, 0] = np.ones(gpu.tiles, bool) if gpu.is_global else gpu.requested[:, :, 0, 0]
    for level in range(lattice.depth + 1):
        for row in range(rows_of(lattice, level)):
            for column in range(columns_of(lattice, level)):
                cell = (level, row, column)
                present = tree.present[cell]
                fails = failing_texels(gpu, cell, present, step) if present.any() else np.zeros_like(gpu.surface)
                if level == lattice.depth:
                    tree.capped |= count_by_tile(fails, gpu.tiles) > 0
                    continue
                refined = present & needs_more(gpu, cell, fails, threshold)
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
    """Look-ups of all pixels with a surface: as many as their tile's tree has samples."""
    per_tile = requested(gpu.lattice, tree).sum(axis=(2, 3))
    return int((by_pixel(per_tile, gpu.surface.shape) * gpu.surface).sum())


def maps(gpu: Gpu, tree: Tree) -> int:
    """Samples that some tile with a surface requests."""
    has_surface = count_by_tile(gpu.surface, gpu.tiles) > 0
    return int((requested(gpu.lattice, tree) & has_surface[:, :, None, None]).any(axis=(0, 1)).sum())
