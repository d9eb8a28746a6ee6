"""Samples of the light moved off their lattice.

Every frame by another step, for `Renderer.refine` to average over; in every pixel of a block by another one, so that
the block together samples the light more densely (Keller and Heidrich, "Interleaved Sampling", 2001).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

_PLASTIC = 1.32471795724474602596
"""The root of x³ = x + 1: steps by its powers fill a square evenly (Roberts 2018, "The unreasonable effectiveness of
quasirandom sequences")."""

OFFSETS = ("none", "stratified")
"""Where in their cells a pixel's samples lie: as in all pixels, or elsewhere in every pixel of 4×4."""

_COLUMN = np.array([[0, 2, 1, 3], [2, 0, 3, 1], [1, 3, 0, 2], [3, 1, 2, 0]])
_ROW = np.array([[0, 2, 1, 3], [1, 3, 0, 2], [3, 1, 2, 0], [2, 0, 3, 1]])
"""By pixel of a block, y first: the quarter of a cell, across and up, that its samples lie in.

Orthogonal Latin squares: each quarter once in every row and column of pixels, each pair of quarters in one pixel.
"""
_BLOCK = 16
"""Pixels of a block."""


def jitter_shift(number: int) -> tuple[float, float]:
    """The `number`-th of a sequence of shifts in [−½, ½)², in steps of the lattice; (0, 0) for number 0."""
    return (
        math.remainder(number / _PLASTIC, 1.0),
        math.remainder(number / _PLASTIC**2, 1.0),
    )


def block_strata() -> npt.NDArray[np.float64]:
    """(16, 2): by pixel of a 4×4 block, row by row, the shift of its samples in steps of the lattice, within (−½, ½).

    Sixteen different shifts along either side of the light, so that an edge along the other crosses them one by one
    (multi-jittered: Chiu, Shirley, Wang 1994).
    """
    across, up = _COLUMN.ravel(), _ROW.ravel()
    return (np.stack([4 * across + up, 4 * up + across], axis=1) + 0.5) / _BLOCK - 0.5


def strata_of(offsets: str) -> int:
    """How many places each sample has."""
    return _BLOCK if offsets == "stratified" else 1


def placed(
    points_at: Callable[[tuple[float, float]], npt.NDArray[np.float64]], jitter: int, offsets: str
) -> npt.NDArray[np.float64]:
    """(places × n, 2): the light's n points, one place after another, where `points_at` gives them for a shift."""
    shift = np.array(jitter_shift(jitter))
    places = block_strata() if offsets == "stratified" else np.zeros((1, 2))
    return np.concatenate([points_at((x, y)) for x, y in places + shift])


def moved(
    steps: npt.NDArray[np.float64], spacing: float, by: npt.NDArray[np.float64] | float
) -> npt.NDArray[np.float64]:
    """Evenly spaced places in [−1, 1], moved by a share of their spacing, and folded back at the ends.

    Places on the ends have half a step to themselves, which folding them back fills: over all shifts, places with
    trapezoid weights cover the light evenly.
    """
    places = steps + np.remainder(np.asarray(by) + 0.5, 1.0) * spacing - 0.5 * spacing
    return np.where(np.abs(places) > 1.0, np.copysign(2.0, places) - places, places)
