"""How wide the soft part of a shadow is, from 10 % to 90 % visibility.

On a profile across one shadow edge the width is a length, `penumbra_width`. On an image of any scene, where edges run
everywhere and cross, it is an area: the pixels with visibility between 10 % and 90 %. As the length of all shadow
edges in view is the same for technique and truth, the ratio of the two areas is the ratio of mean penumbra widths,
and `penumbra_width_error` is that ratio less one. Unlike the rmse it says whether penumbrae are too wide or too
narrow; banding and noise that stay between the limits leave it alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.metrics.checks import check_positive, checked

LOW, HIGH = 0.1, 0.9


def penumbra_width(profile: npt.NDArray[Any], spacing: float = 1.0) -> npt.NDArray[np.float64]:
    """10–90 % widths of visibility profiles (..., n) across one shadow edge each: (...) float64, in units of `spacing`.

    The distance between the last crossing of one limit and the nearest crossing of the other, each interpolated
    between pixels; the profile may rise or fall. A linear ramp of width w gives 0.8 w, a step between two pixels 0.8.
    NaN where a profile does not pass both limits. Take columns of an image as `image.T`.
    """
    profile = np.asarray(profile)
    if profile.ndim < 1 or profile.shape[-1] < 2 or not np.issubdtype(profile.dtype, np.floating):
        raise OptionError(f"profile must be (..., n ≥ 2) floating-point numbers, got {profile.shape} {profile.dtype}")
    if not np.isfinite(profile).all():
        raise OptionError("profile must be finite")
    check_positive(spacing, "spacing")
    rows = profile.astype(np.float64).reshape(-1, profile.shape[-1])
    widths = np.array([_width(row if row[-1] >= row[0] else row[::-1]) for row in rows])
    return spacing * widths.reshape(profile.shape[:-1])


def _width(rising: npt.NDArray[np.float64]) -> float:
    """From the last point at or below the lower limit that precedes the first point at or above the upper one."""
    above = np.flatnonzero(rising >= HIGH)
    below = np.flatnonzero(rising[: above[0]] <= LOW) if len(above) else above
    if not len(below):
        return np.nan
    start, end = below[-1], above[0]
    leaves = start + (LOW - rising[start]) / (rising[start + 1] - rising[start])
    arrives = end - (rising[end] - HIGH) / (rising[end] - rising[end - 1])
    return arrives - leaves


def penumbra_width_error(
    visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None
) -> float:
    """Relative error of the mean penumbra width: 0.1 where penumbrae are 10 % too wide, −1 where they are missing.

    (A − A*) / max(A*, 1) with A, A* the pixels whose visibility, true visibility lies strictly between 10 % and 90 %:
    where the truth has none, the count of false ones. A* tells how far to trust it.
    """
    visibility, truth, mask = checked(visibility, truth, mask)
    area = np.count_nonzero(mask & (visibility > LOW) & (visibility < HIGH))
    true_area = np.count_nonzero(mask & (truth > LOW) & (truth < HIGH))
    return float((area - true_area) / max(true_area, 1))
