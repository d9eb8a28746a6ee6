"""Pictures of what adaptive sampling did in a frame: its trees, its comparison, and where its look-ups went.

    renderer = ss.Renderer(scene, technique="adaptive")
    renderer.render(camera)
    decisions = read_decisions(renderer)
    image = lookups_picture(decisions)

The GPU's buffers are read between frames, so that a frame itself reads back nothing more. All pictures are float32 RGB
in 0..1, row 0 at the top, to be shown as they are. They show the light that was sampled last.

    tree_picture          the light with its cells and samples            [Schwaerzler2012 Fig. 5]
    comparison_picture    how many corners of a cell each pixel sees      [Schwaerzler2012 Fig. 6]
    lookups_picture       look-ups of each pixel, as a heat map with its scale
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.errors import OptionError
from softshadows.lights.lattice import Lattice
from softshadows.techniques.adaptive.adaptive import AdaptivePass
from softshadows.techniques.adaptive.tree_buffers import TILE

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]
Words = npt.NDArray[np.uint32]
Cell = tuple[int, int, int]
"""Level, row and column; row 0 lies at the light's lower edge, column 0 at its left one."""

ROOT: Cell = (0, 0, 0)
ROW_BITS = 16
"""Bits of a row of samples, in the words with two rows each; the 17th samples of all rows share a word (tree.wgsl)."""

HEAT = ("000004", "1c1044", "4f127b", "812581", "b5367a", "e55964", "fb8761", "fec287", "fcfdbf")
"""Nine equal steps of matplotlib's "magma" (public domain): its lightness rises evenly."""
BACKGROUND = (0.25, 0.27, 0.30)
COUNT_COLORS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.15, 0.35, 1.0), (0.0, 0.0, 0.0))
"""Colours of 0..4 visible corners, as in the paper's figure 6: red 1, green 2, blue 3, black none or all."""

CELL_PIXELS = 32
"""In the picture of the light, along a cell of the deepest level."""
MARGIN = 24
DEPTH_SHADES = (0.08, 0.72)
"""Places of the root and of the deepest leaves on the heat scale: white lines show on all of them."""
DOT = 3
SCALE_HEIGHT = 44
"""Pixels below a picture that its scale takes."""


@dataclass(frozen=True, eq=False)
class Decisions:
    """What the GPU decided in a frame, for one light.

    surface (height, width) bool; requested (tiles down, tiles across, rows, columns) bool, the samples of each tile's
    tree; refined, by level, (tiles down, tiles across, cell rows, cell columns) bool; visibility_bits (height, width,
    rows) uint32, bit x of row y saying that the pixel sees sample (x, y), if its tree has it. Tiles have TILE×TILE
    pixels.
    """

    lattice: Lattice
    surface: Bools
    requested: Bools
    refined: list[Bools]
    visibility_bits: Words

    @property
    def lookups(self) -> npt.NDArray[np.int64]:
        """(height, width): how many shadow maps the pixel looked into; their mean is `stats.lookups_per_pixel`."""
        return self.by_pixel(self.requested.sum(axis=(2, 3))) * self.surface

    def present(self, cell: Cell) -> Bools:
        """(tiles down, tiles across): is the cell in the tile's tree?"""
        level, row, column = cell
        if level == 0:
            return self.requested[:, :, 0, 0]
        up, across = (row // 2 if self.lattice.has_rows else 0), (column // 2 if self.lattice.has_columns else 0)
        return self.refined[level - 1][:, :, up, across]

    def sees(self, row: int, column: int) -> Bools:
        """(height, width): does the pixel see the sample? False too where its tree does not have it."""
        asked = self.by_pixel(self.requested[:, :, row, column]) & self.surface
        return asked & (self.visibility_bits[:, :, row] >> np.uint32(column) & 1).astype(bool)

    def by_pixel(self, tiles: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """(height, width): each pixel's value in (tiles down, tiles across)."""
        height, width = self.surface.shape
        return tiles.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width]


def read_decisions(renderer: Any) -> Decisions:
    """The decisions of the last frame of `renderer`, an `ss.Renderer`; OptionError where there is none of this kind."""
    work = getattr(renderer.passes, "technique", None)
    if not isinstance(work, AdaptivePass) or not work._by_light:
        raise OptionError(
            "these pictures show adaptive sampling: render a frame with technique 'adaptive' and a light first"
        )
    sampling = work._by_light[-1][0]
    device, lattice = sampling._context.gpu.device, sampling.lattice

    def words(buffer: wgpu.GPUBuffer) -> Words:
        return np.asarray(device.queue.read_buffer(buffer)).view("<u4")

    surface = _surface(device, sampling._context.gbuffer.position)
    height, width = surface.shape
    tiles = (-(-height // TILE), -(-width // TILE))

    cell_rows = sum(_cell_rows(lattice, level) for level in range(lattice.depth))
    trees = (1, 1) if sampling.is_global else tiles
    row_words = words(sampling.buffers.trees)[: trees[0] * trees[1] * (lattice.rows + cell_rows)]
    bits = _bits(row_words.reshape(*trees, -1), lattice.columns)
    bits = np.broadcast_to(bits, (*tiles, *bits.shape[2:]))  # all tiles may share one tree
    requested = bits[:, :, : lattice.rows]
    all_refined = bits[:, :, lattice.rows :]
    refined, first = [], 0
    for level in range(lattice.depth):
        rows = _cell_rows(lattice, level)
        found = all_refined[:, :, first : first + rows, : max(lattice.columns - 1, 1) : lattice.spacing(level)]
        refined.append(found)
        first += rows
    bits = _row_bits(words(sampling.buffers.visibility_bits), lattice, tiles)[:height, :width]
    return Decisions(lattice, surface, requested, refined, bits)


def _surface(device: wgpu.GPUDevice, position: wgpu.GPUTexture) -> Bools:
    """(height, width): where the G-buffer's position has a depth."""
    width, height, _ = position.size
    data = device.queue.read_texture(
        {"texture": position}, {"bytes_per_row": 16 * width, "rows_per_image": height}, (width, height, 1)
    )
    return np.asarray(data).view("<f4").reshape(height, width, 4)[..., 3] > 0.0


def _row_bits(words: Words, lattice: Lattice, tiles: tuple[int, int]) -> Words:
    """(height, width, rows) of all tiles' pixels: tree.wgsl mask_index()."""
    count = -(-lattice.rows // 2) + 1
    visibility_bits = words[: tiles[0] * tiles[1] * count * TILE * TILE].reshape(*tiles, count, TILE, TILE)
    visibility_bits = visibility_bits.transpose(0, 3, 1, 4, 2).reshape(tiles[0] * TILE, tiles[1] * TILE, count)
    rows = np.arange(lattice.rows)
    pairs = visibility_bits[..., rows // 2] >> (ROW_BITS * (rows % 2)).astype(np.uint32) & np.uint32(0xFFFF)
    lasts = visibility_bits[..., -1:] >> rows.astype(np.uint32) & np.uint32(1)
    return pairs | lasts << np.uint32(ROW_BITS)


def _bits(words: Words, count: int) -> Bools:
    """(..., count): the words' lowest bits."""
    return (words[..., None] >> np.arange(count, dtype=np.uint32) & 1).astype(bool)


def _cell_rows(lattice: Lattice, level: int) -> int:
    return 1 << level if lattice.has_rows else 1


def _cell_columns(lattice: Lattice, level: int) -> int:
    return 1 << level if lattice.has_columns else 1


def _corners(lattice: Lattice, cell: Cell) -> list[tuple[int, int]]:
    """(row, column) of the samples at a cell's corners: four, two on a line, one on a point."""
    level, row, column = cell
    step = lattice.spacing(level)
    rows = [row * step, (row + 1) * step] if lattice.has_rows else [0]
    columns = [column * step, (column + 1) * step] if lattice.has_columns else [0]
    return [(r, c) for r in rows for c in columns]


def busiest_tile(decisions: Decisions) -> tuple[int, int]:
    """(row, column) of the tile whose tree has most samples; the first of several."""
    counts = decisions.requested.sum(axis=(2, 3))
    row, column = np.unravel_index(int(counts.argmax()), counts.shape)
    return int(row), int(column)


def tree_picture(decisions: Decisions, tile: tuple[int, int] | None = None) -> Floats:
    """[Schwaerzler2012 Fig. 5] The light, its right to the right, with the cells and samples of one tile's tree.

    `tile` (row, column); None shows all trees at once. The shade is the depth of the leaf, the deepest of all trees; a
    sample's dot is white, and greyer the fewer trees have it. OptionError for a tile that is not there.
    """
    lattice, requested = decisions.lattice, decisions.requested
    down, across = requested.shape[:2]
    if tile is None:
        chosen = requested.any(axis=(2, 3))
    else:
        if not (0 <= tile[0] < down and 0 <= tile[1] < across):
            raise OptionError(f"tile must be (row, column) within {down}×{across} tiles, got {tile!r}")
        chosen = np.zeros((down, across), bool)
        chosen[tile] = True
    columns, rows = max(lattice.columns - 1, 1), max(lattice.rows - 1, 1)
    image = np.zeros((rows * CELL_PIXELS + 2 * MARGIN, columns * CELL_PIXELS + 2 * MARGIN, 3), np.float32)
    image[:] = BACKGROUND
    trees = max(int((chosen & requested.any(axis=(2, 3))).sum()), 1)
    depth = np.zeros((rows, columns), int)
    outlines = []
    for level in range(lattice.depth + 1):
        step = lattice.spacing(level)
        for row in range(_cell_rows(lattice, level)):
            for column in range(_cell_columns(lattice, level)):
                if (decisions.present((level, row, column)) & chosen).any():
                    depth[row * step : (row + 1) * step, column * step : (column + 1) * step] = level
                    outlines.append((level, row, column))
    inside = image[MARGIN:-MARGIN, MARGIN:-MARGIN]
    shade = heat(_depth_shade(depth, lattice))[::-1]
    inside[:] = shade.repeat(CELL_PIXELS, axis=0).repeat(CELL_PIXELS, axis=1)
    for cell in outlines:
        _outline(image, lattice, cell)
    share = np.sum(requested[chosen], axis=0) / trees
    for row, column in np.argwhere(share > 0.0).tolist():
        y, x = image.shape[0] - 1 - MARGIN - row * CELL_PIXELS, MARGIN + column * CELL_PIXELS
        image[y - DOT : y + DOT + 1, x - DOT : x + DOT + 1] = 0.0
        image[y - DOT + 1 : y + DOT, x - DOT + 1 : x + DOT] = 0.3 + 0.7 * np.sqrt(share[row, column])
    ticks = [(_depth_shade(level, lattice), str(level)) for level in range(lattice.depth + 1)]
    return _with_scale(image, ticks, f"depth of the leaves; {np.count_nonzero(share)} of {share.size} samples")


def _depth_shade(depth: Any, lattice: Lattice) -> Any:
    """Where in `heat` a leaf of that depth is shown."""
    return DEPTH_SHADES[0] + (DEPTH_SHADES[1] - DEPTH_SHADES[0]) * depth / max(lattice.depth, 1)


def _outline(image: Floats, lattice: Lattice, cell: Cell) -> None:
    """Draw a cell's border, row 0 at the bottom."""
    level, row, column = cell
    size = lattice.spacing(level) * CELL_PIXELS
    left, right = MARGIN + column * size, MARGIN + (column + 1) * size
    tall = size if lattice.has_rows else CELL_PIXELS
    bottom = image.shape[0] - 1 - MARGIN - row * tall
    top = bottom - tall
    right = right if lattice.has_columns else left + CELL_PIXELS
    line = (0.85, 0.85, 0.85)
    image[[top, bottom], left : right + 1] = line
    image[top : bottom + 1, left] = line
    image[top : bottom + 1, right] = line


def comparison_picture(decisions: Decisions, cell: Cell = ROOT) -> Floats:
    """[Schwaerzler2012 Fig. 6] (height, width, 3): how many of a cell's corners each pixel sees.

    Red 1, green 2, blue 3; black none or all, and where there is no surface or the pixel's tree lacks the cell. On a
    line, red is one of two. OptionError for a cell that the lattice does not have.
    """
    lattice, (level, row, column) = decisions.lattice, cell
    if not (
        0 <= level <= lattice.depth
        and 0 <= row < _cell_rows(lattice, level)
        and 0 <= column < _cell_columns(lattice, level)
    ):
        raise OptionError(f"cell must be a level, row and column of a light of depth {lattice.depth}, got {cell!r}")
    corners = _corners(lattice, cell)
    number = np.sum([decisions.sees(r, c) for r, c in corners], axis=0)
    shown = decisions.by_pixel(decisions.present(cell)) & (number < len(corners))
    return np.array(COUNT_COLORS, np.float32)[np.where(shown, number, 0)]


def lookups_picture(decisions: Decisions) -> Floats:
    """(height + SCALE_HEIGHT, width, 3): each pixel's look-ups, with their logarithmic scale; background is grey."""
    lattice = decisions.lattice
    most = lattice.rows * lattice.columns
    image = heat(_log_share(decisions.lookups, most))
    image[~decisions.surface] = BACKGROUND
    uniform = [((1 << level) + 1) ** lattice.dimensions for level in range(lattice.depth + 1)]
    ticks = [(float(_log_share(np.array(count), most)), str(count)) for count in uniform]
    return _with_scale(image, ticks, f"look-ups per pixel, mean {decisions.lookups.mean():.1f}")


def _log_share(counts: npt.NDArray[Any], most: int) -> npt.NDArray[np.float64]:
    """0 for none, 1 for `most`, in equal steps for equal factors."""
    return np.log1p(counts) / np.log1p(most)


def heat(share: npt.NDArray[Any]) -> Floats:
    """(..., 3): colours for 0..1, from black over violet and orange to pale yellow."""
    colors = np.array([[int(text[i : i + 2], 16) for i in (0, 2, 4)] for text in HEAT]) / 255.0
    at = np.clip(share, 0.0, 1.0) * (len(HEAT) - 1)
    steps = np.arange(len(HEAT))
    return np.stack([np.interp(at, steps, channel) for channel in colors.T], axis=-1).astype(np.float32)


def _with_scale(image: Floats, ticks: list[tuple[float, str]], caption: str) -> Floats:
    """The picture, and below it what its colours mean."""
    from PIL import Image, ImageDraw, ImageFont

    width = image.shape[1]
    strip = np.zeros((SCALE_HEIGHT, width, 3), np.float32)
    left, right = 8, max(width - 9, 9)
    strip[4:14, left : right + 1] = heat(np.linspace(0.0, 1.0, right + 1 - left))[: width - left]
    drawn = Image.fromarray(np.rint(255.0 * strip).astype(np.uint8))
    draw, font = ImageDraw.Draw(drawn), ImageFont.load_default()
    for share, text in ticks:
        x = left + share * (right - left)
        half = draw.textlength(text, font=font) / 2.0
        draw.line([(x, 2), (x, 16)], fill=(255, 255, 255))
        draw.text((min(max(x, half), width - half), 16), text, fill=(255, 255, 255), font=font, anchor="ma")
    draw.text((left, SCALE_HEIGHT - 2), caption, fill=(200, 200, 200), font=font, anchor="ld")
    return np.concatenate([image, np.asarray(drawn, np.float32) / 255.0])


def all_pictures(renderer: Any, tile: tuple[int, int] | None = None) -> dict[str, Floats]:
    """By name: the light with all trees and with one tile's (default: the busiest), the root's comparison, look-ups."""
    decisions = read_decisions(renderer)
    return {
        "light": tree_picture(decisions),
        "light-of-tile": tree_picture(decisions, tile or busiest_tile(decisions)),
        "comparison": comparison_picture(decisions),
        "lookups": lookups_picture(decisions),
    }
