"""FLIP: how different two pictures look when one flips between them (Andersson et al., HPG 2020)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from softshadows.errors import DeviceError, OptionError
from softshadows.metrics.checks import check_positive

PIXELS_PER_DEGREE = 67.0
"""FLIP's own default: a 0.7 m wide display of 3840 pixels, seen from 0.7 m."""


class Flip(NamedTuple):
    """`mean` over all pixels, 0 (alike) to 1, and the `map` (height, width) float32 it is the mean of."""

    mean: float
    map: npt.NDArray[np.float32]


def flip(
    picture: npt.NDArray[Any],
    reference: npt.NDArray[Any],
    *,
    linear: bool = False,
    pixels_per_degree: float = PIXELS_PER_DEGREE,
) -> Flip:
    """LDR-FLIP between two (height, width, 3) floating-point pictures with values in 0..1.

    Values are sRGB-encoded, as in an 8-bit file divided by 255, or linear where `linear` is set: tone-map radiance
    first. Raises OptionError for other shapes or dtypes and for values that are not finite or outside 0..1 (the
    evaluator itself returns a plausible number for NaN), DeviceError where flip-evaluator cannot be imported.
    """
    for name, image in (("picture", np.asarray(picture)), ("reference", np.asarray(reference))):
        if image.ndim != 3 or image.shape[2] != 3 or not image.size or not np.issubdtype(image.dtype, np.floating):
            raise OptionError(f"{name} must be (height, width, 3) floating point, got {image.shape} {image.dtype}")
        if not (np.isfinite(image).all() and image.min() >= 0.0 and image.max() <= 1.0):
            raise OptionError(f"{name} must hold finite values in 0..1")
    if np.shape(picture) != np.shape(reference):
        raise OptionError(f"the pictures must have one shape, got {np.shape(picture)} and {np.shape(reference)}")
    check_positive(pixels_per_degree, "pixels_per_degree")
    try:
        import flip_evaluator
    except ImportError as error:
        raise DeviceError(
            "FLIP needs flip-evaluator, which cannot be imported here: pip install flip-evaluator "
            "(wheels exist for x86-64 Linux, Windows and macOS)"
        ) from error
    try:
        difference, mean, _ = flip_evaluator.evaluate(
            np.ascontiguousarray(reference, np.float32),
            np.ascontiguousarray(picture, np.float32),
            "LDR",
            inputsRGB=not linear,
            applyMagma=False,
            parameters={"ppd": float(pixels_per_degree)},
        )
    except SystemExit as error:  # how the evaluator reports arguments it dislikes
        raise OptionError("flip-evaluator refused these pictures") from error
    return Flip(float(mean), np.asarray(difference, np.float32).reshape(np.shape(picture)[:2]))
