"""Samples of the light moved off their lattice, a little further every frame: what `Renderer.refine` averages over."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

_PLASTIC = 1.32471795724474602596
"""The root of x³ = x + 1: steps by its powers fill a square evenly (Roberts 2018, "The unreasonable effectiveness of
quasirandom sequences")."""


def sub_position(number: int) -> tuple[float, float]:
    """The `number`-th of a sequence of shifts in [−½, ½)², in steps of the lattice; (0, 0) for number 0."""
    return (
        math.remainder(number / _PLASTIC, 1.0),
        math.remainder(number / _PLASTIC**2, 1.0),
    )


def moved(
    steps: npt.NDArray[np.float64], spacing: float, by: npt.NDArray[np.float64] | float
) -> npt.NDArray[np.float64]:
    """Evenly spaced places in [−1, 1], moved by a share of their spacing, and folded back at the ends.

    Places on the ends have half a step to themselves, which folding them back fills: over all shifts, places with
    trapezoid weights cover the light evenly.
    """
    places = steps + np.remainder(np.asarray(by) + 0.5, 1.0) * spacing - 0.5 * spacing
    return np.where(np.abs(places) > 1.0, np.copysign(2.0, places) - places, places)
