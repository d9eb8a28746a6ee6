"""What every metric demands of its images, so that a wrong array is an error and not a wrong figure."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


def checked(
    visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None
) -> tuple[Array, Array, Bools]:
    """The three as (height, width) float64, float64, bool; no mask means all pixels.

    Raises OptionError for other shapes or dtypes, for values under the mask that are not finite, and for a truth
    outside 0..1. Visibility may lie outside: that is an error to be measured.
    """
    visibility, truth = np.asarray(visibility), np.asarray(truth)
    if truth.ndim != 2 or visibility.shape != truth.shape:
        raise OptionError(
            "visibility and truth must be images (height, width) of one shape and light, as frame.visibility[0], "
            f"got {visibility.shape} and {truth.shape}"
        )
    mask = np.ones(truth.shape, bool) if mask is None else np.asarray(mask)
    if mask.shape != truth.shape or mask.dtype != np.bool_:
        raise OptionError(f"mask must be {truth.shape} bool, got {mask.shape} {mask.dtype}")
    for name, image in (("visibility", visibility), ("truth", truth)):
        if not np.issubdtype(image.dtype, np.floating):
            raise OptionError(f"{name} must hold floating-point numbers, got {image.dtype}")
        if not np.isfinite(image[mask]).all():
            raise OptionError(f"{name} must be finite wherever the mask is true")
    if mask.any() and not (truth[mask].min() >= 0.0 and truth[mask].max() <= 1.0):
        raise OptionError("truth must lie in 0..1 wherever the mask is true")
    return visibility.astype(np.float64), truth.astype(np.float64), mask


def check_positive(value: object, name: str) -> None:
    """Raises OptionError unless `value` is a finite number above zero."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < float(value) < np.inf:
        raise OptionError(f"{name} must be a positive number, got {value!r}")
