"""Umbra, lit and penumbra by the truth, and the two failures that the eye finds first: light leaks and false shadows.

A pixel belongs to the umbra where true visibility ≤ 0.02, to the lit region where it is ≥ 0.98, else to the penumbra.
Umbra and lit region are eroded by two pixels, so that an edge drawn a pixel off counts in rmse but not as a leak.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.metrics.checks import Bools, check_positive, checked

UMBRA, LIT = 0.02, 0.98
EROSION = 2
LEAK, FALSE_SHADOW = 0.1, 0.9

TOO_LIGHT = np.array([0.90, 0.35, 0.00], np.float32)
TOO_DARK = np.array([0.00, 0.35, 0.80], np.float32)
OUTSIDE = np.array([0.50, 0.50, 0.50], np.float32)


@dataclass(frozen=True, eq=False)
class Regions:
    """Disjoint (height, width) bool images: umbra and lit eroded, penumbra whole. The eroded rims belong to none."""

    umbra: Bools
    lit: Bools
    penumbra: Bools


def regions(truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None) -> Regions:
    """The regions of a true visibility image (height, width), 0..1. What the mask leaves out belongs to no region.

    A pixel stays in the umbra (or the lit region) if all 5 × 5 pixels around it lie in it, inside mask and image.
    Raises OptionError for arrays of other kinds, as all of `metrics` does.
    """
    _, truth, mask = checked(truth, truth, mask)
    umbra, lit = mask & (truth <= UMBRA), mask & (truth >= LIT)
    return Regions(_eroded(umbra), _eroded(lit), mask & ~umbra & ~lit)


def leak_mask(visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None) -> Bools:
    """(height, width) bool: pixels of the eroded umbra that show visibility > 0.1."""
    visibility, truth, mask = checked(visibility, truth, mask)
    return regions(truth, mask).umbra & (visibility > LEAK)


def false_shadow_mask(
    visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None
) -> Bools:
    """(height, width) bool: pixels of the eroded lit region that show visibility < 0.9."""
    visibility, truth, mask = checked(visibility, truth, mask)
    return regions(truth, mask).lit & (visibility < FALSE_SHADOW)


def signed_error_image(
    visibility: npt.NDArray[Any],
    truth: npt.NDArray[Any],
    mask: npt.NDArray[Any] | None = None,
    *,
    amplification: float = 5.0,
) -> npt.NDArray[np.float32]:
    """A picture of visibility − truth: (height, width, 3) float32, 0..1, sRGB.

    White is no error, orange too light (a leak), blue too dark (a false shadow), both told apart by colour-blind
    eyes; full colour at an error of 1/amplification. Grey lies outside the mask.
    """
    visibility, truth, mask = checked(visibility, truth, mask)
    check_positive(amplification, "amplification")
    error = np.where(mask, visibility - truth, 0.0).astype(np.float32)
    strength = np.clip(np.abs(error) * np.float32(amplification), 0.0, 1.0)[..., None]
    colour = np.where(error[..., None] > 0.0, TOO_LIGHT, TOO_DARK)
    return np.where(mask[..., None], 1.0 - strength * (1.0 - colour), OUTSIDE).astype(np.float32)


def _eroded(region: Bools) -> Bools:
    """`region` less every pixel within EROSION pixels (also diagonally) of one outside it, or of the image's border."""
    height, width = region.shape
    padded = np.pad(region, EROSION)
    steps = range(2 * EROSION + 1)
    across = np.logical_and.reduce([padded[:, step : step + width] for step in steps])
    return np.logical_and.reduce([across[step : step + height] for step in steps])
