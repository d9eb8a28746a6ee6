"""The figures by which a visibility image is judged against the truth."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.metrics.checks import checked
from softshadows.metrics.leaks import FALSE_SHADOW, LEAK, regions
from softshadows.metrics.penumbra import penumbra_width_error


@dataclass(frozen=True)
class Comparison:
    """What `compare` found. Errors are visibility − truth; a figure over no pixels is 0.0, and its count says so."""

    rmse: float
    """Root of the mean squared error over all pixels."""
    penumbra_rmse: float
    """The same over the true penumbra: unlike rmse, it does not shrink as more of the scene is plainly lit."""
    bias: float
    """Mean signed error: positive is too light."""
    p99: float
    """99th percentile of the absolute error."""
    p99_9: float
    """99.9th percentile of the absolute error."""
    max: float
    """Largest absolute error."""
    leak_rate: float
    """Share of the eroded umbra with visibility > 0.1."""
    false_shadow_rate: float
    """Share of the eroded lit region with visibility < 0.9."""
    penumbra_width_error: float
    """Relative error of the mean 10–90 % penumbra width: positive is too wide."""
    pixels: int
    """Pixels compared."""
    umbra_pixels: int
    """Pixels of the eroded umbra."""
    lit_pixels: int
    """Pixels of the eroded lit region."""
    penumbra_pixels: int
    """Pixels of the true penumbra."""

    def as_dict(self) -> dict[str, float | int]:
        """All fields by name, as plain numbers for JSON."""
        return asdict(self)


def compare(visibility: npt.NDArray[Any], truth: npt.NDArray[Any], mask: npt.NDArray[Any] | None = None) -> Comparison:
    """Compare `visibility` with `truth`, (height, width) floating point, where `mask` (height, width) bool is true.

    Use mask = frame.surface & frame.facing[light]: elsewhere darkness is not the technique's business. Umbra, lit
    region and penumbra are those of the truth (see `metrics.leaks`). Raises OptionError for arrays of other shapes or
    dtypes and for values that are not finite.
    """
    visibility, truth, mask = checked(visibility, truth, mask)
    where = regions(truth, mask)
    error = visibility - truth
    size = np.abs(error[mask])
    p99, p99_9 = np.percentile(size, [99.0, 99.9]) if len(size) else (0.0, 0.0)
    return Comparison(
        rmse=_root_mean_square(error[mask]),
        penumbra_rmse=_root_mean_square(error[where.penumbra]),
        bias=_mean(error[mask]),
        p99=float(p99),
        p99_9=float(p99_9),
        max=float(size.max(initial=0.0)),
        leak_rate=_mean(visibility[where.umbra] > LEAK),
        false_shadow_rate=_mean(visibility[where.lit] < FALSE_SHADOW),
        penumbra_width_error=penumbra_width_error(visibility, truth, mask),
        pixels=int(np.count_nonzero(mask)),
        umbra_pixels=int(np.count_nonzero(where.umbra)),
        lit_pixels=int(np.count_nonzero(where.lit)),
        penumbra_pixels=int(np.count_nonzero(where.penumbra)),
    )


def _mean(values: npt.NDArray[Any]) -> float:
    return float(values.mean()) if len(values) else 0.0


def _root_mean_square(values: npt.NDArray[np.float64]) -> float:
    return float(np.sqrt(_mean(values**2)))
