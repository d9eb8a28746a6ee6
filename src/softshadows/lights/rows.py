"""Rows of samples, for walks that look at the whole light at once (techniques/bitmask).

A rectangle is cut into rows, each a line of 32 samples that climbs by a part of a row's height over the light's width,
so that an edge along the light's sides does not meet all of a row at one place. A disk has those of its square that lie
in it; a line has eight times as many samples as a rectangle has rows, evenly spaced.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows.lights.jitter import block_strata, jitter_shift
from softshadows.scene.lights import Light

COLUMNS = 32
"""Samples of a row: the bits of a word."""
SLANT = 0.62
"""How far a row climbs over the light's width, in row heights: docs/decisions/0019-bitmask.md."""
LINE_SAMPLES_PER_ROW = 8


@dataclass(frozen=True)
class Placing:
    """Where rows lie in their share of the light: how far they climb over its width, in rows, and how far all samples
    are moved, in columns and rows. With ½ slant + |row| ≤ ½ and |column| ≤ ½ all stay on the light.
    """

    slant: float = SLANT
    column: float = 0.0
    row: float = 0.0


def placing_of(refinement: int) -> Placing:
    """The placing of a frame that `refinement` others were averaged before: straight rows, that come to every place."""
    column, row = jitter_shift(refinement)
    return Placing(0.0, column, row) if refinement else Placing()


def block_shifts() -> npt.NDArray[np.float64]:
    """(16, 2): by pixel of a 4×4 block, row by row, a shift in columns and rows for slanted rows."""
    return block_strata() * [1.0, 1.0 - SLANT]


@dataclass(frozen=True, eq=False)
class RowSamples:
    """The samples of a light: points (words × 32, 2) float64, metres of light space; whether each lies on the light,
    (words, 32) bool. A rectangle has a word for each row, from the bottom up; a line, for each 32 samples.
    """

    points: npt.NDArray[np.float64]
    is_on_light: npt.NDArray[np.bool_]

    @property
    def count(self) -> int:
        """Samples on the light."""
        return int(np.count_nonzero(self.is_on_light))

    @property
    def words_outside(self) -> npt.NDArray[np.uint32]:
        """(words,): a bit for each sample that does not lie on the light."""
        bits = np.uint32(1) << np.arange(COLUMNS, dtype=np.uint32)
        return (~self.is_on_light * bits).sum(axis=1, dtype=np.uint32)


def row_samples(light: Light, rows: int, placing: Placing | None = None) -> RowSamples:
    """The samples of a light with an extent, in `rows` rows."""
    placing = placing or Placing()
    across, up = light.half_extent
    column = (np.arange(COLUMNS) + 0.5 + placing.column) / COLUMNS - 0.5
    if across == 0.0 or up == 0.0:
        words = rows * LINE_SAMPLES_PER_ROW // COLUMNS
        along = ((np.arange(words)[:, None] + 0.5 + column) / words - 0.5) * 2.0
        points = np.stack([along * across, along * up], axis=-1)
        return RowSamples(points.reshape(-1, 2), np.ones((words, COLUMNS), bool))
    row = np.arange(rows)[:, None] + 0.5 + placing.row - rows / 2.0 + placing.slant * column
    points = np.stack(np.broadcast_arrays(2.0 * across * column, 2.0 * up / rows * row), axis=-1)
    is_on_light = light.holds(points)
    return RowSamples(points.reshape(-1, 2), is_on_light)
