"""Where a visibility image errs most, so that a report can show it without anybody searching."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.metrics.checks import checked


class Region(NamedTuple):
    """A square of pixels, cut off at the image's border: its first column and row, its extent, and its error."""

    x: int
    y: int
    width: int
    height: int
    rmse: float
    """Over the pixels of the square that the mask holds."""


def worst_region(
    visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None, *, side: int = 48
) -> Region | None:
    """The square of `side` pixels with the largest sum of squared errors; the first of equals, row by row.

    None where there is no error. Raises OptionError for arrays of other kinds, as all of `metrics` does.
    """
    visibility, truth, mask = checked(visibility, truth, mask)
    if isinstance(side, bool) or not isinstance(side, int) or side < 1:
        raise OptionError(f"side must be a whole number of pixels of at least 1, got {side!r}")
    rows, columns = (min(side, extent) for extent in truth.shape)
    squared = np.where(mask, visibility - truth, 0.0) ** 2
    sums = _box_sums(squared, rows, columns)
    y, x = (int(index) for index in np.unravel_index(np.argmax(sums), sums.shape))
    inside = squared[y : y + rows, x : x + columns]
    if not inside.any():
        return None
    counted = int(np.count_nonzero(mask[y : y + rows, x : x + columns]))
    return Region(x, y, columns, rows, float(np.sqrt(inside.sum() / counted)))


def _box_sums(image: npt.NDArray[np.float64], rows: int, columns: int) -> npt.NDArray[np.float64]:
    """Sums over every rows × columns box that lies inside `image`, from its summed-area table."""
    table = np.pad(image, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    return table[rows:, columns:] - table[:-rows, columns:] - table[rows:, :-columns] + table[:-rows, :-columns]
