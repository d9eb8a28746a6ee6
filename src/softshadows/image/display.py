"""Linear radiance to an 8-bit sRGB picture: exposure, the ACES film curve, the sRGB encoding. numpy only.

The curve is Stephen Hill's fit of the ACES reference rendering and output transforms for sRGB displays (ACES.hlsl of
Pettineo's BakingLab, MIT licence). Exposure comes first: `exposure` in stops, or automatic, which brings the
log-average luminance of what is lit to mid-grey (Reinhard et al., "Photographic Tone Reproduction for Digital Images",
SIGGRAPH 2002), unless that would bleach a good part of them. The result depends on nothing but the arguments.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Relative luminance of linear sRGB: ITU-R BT.709."""

MID_GREY = 0.18
"""The reflectance that automatic exposure brings the log-average to: Reinhard et al. 2002, section 3.1."""

BRIGHT_PERCENTILE = 99.0
DARKEST_STOPS = 8.0
"""What counts for automatic exposure: pixels at most 8 stops darker than the 99th percentile of the lit ones, about
what a display can show, so that an umbra of almost nothing does not brighten the whole picture."""

PAPER_PERCENTILE = 90.0
PAPER_WHITE = 1.0
"""Automatic exposure brings at most a tenth of what is lit above the luminance of white paper under mid-grey's light,
so that a bright floor beside much dim wall keeps its texture."""

MAX_STOPS = 64.0

CURVE_EXPOSURE = 1.0 / 0.6
"""Scale before the curve, as three.js uses it with the same fit: mid-grey becomes 0.21, without it 0.11."""

ACES_INPUT = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
"""Linear sRGB to the space of the curve (AP1, desaturated); white stays white."""
ACES_OUTPUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])


def display(radiance: npt.NDArray[np.floating], *, exposure: float | None = None) -> npt.NDArray[np.uint8]:
    """(height, width, 3) linear radiance as (height, width, 3) uint8 sRGB.

    `exposure` multiplies by 2^exposure; None is automatic. NaN is shown as black, +inf as white. Raises
    OptionError for another shape and for an exposure that is not a number in -64..64.
    """
    radiance = np.asarray(radiance, np.float64)
    if radiance.ndim != 3 or radiance.shape[2] != 3:
        raise OptionError(f"radiance must have the shape (height, width, 3), got {radiance.shape}")
    if exposure is None:
        exposure = automatic_exposure(radiance)
    elif not abs(exposure) <= MAX_STOPS:  # also refuses NaN
        raise OptionError(f"exposure must be a number of stops in {-MAX_STOPS:g}..{MAX_STOPS:g}, got {exposure!r}")
    brightest = float(np.finfo(np.float32).max)
    finite = np.clip(np.nan_to_num(radiance, nan=0.0, posinf=brightest, neginf=0.0), 0.0, brightest)
    return to_8_bit(encode_srgb(film_curve(finite * 2.0**exposure)))


def automatic_exposure(radiance: npt.NDArray[np.floating]) -> float:
    """Stops that bring the log-average luminance of what is lit to mid-grey, fewer where much of it would be bleached.

    Takes (..., 3); 0 for a black picture.
    """
    luminance = np.asarray(radiance, np.float64) @ LUMINANCE
    luminance = luminance[np.isfinite(luminance) & (luminance > 0.0)]
    if not luminance.size:
        return 0.0
    stops = np.log2(luminance)
    counted = stops[stops >= np.percentile(stops, BRIGHT_PERCENTILE) - DARKEST_STOPS]
    wanted = np.log2(MID_GREY) - counted.mean()
    most = np.log2(PAPER_WHITE) - np.percentile(counted, PAPER_PERCENTILE)
    return float(np.clip(min(wanted, most), -MAX_STOPS, MAX_STOPS))


def film_curve(color: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Exposed linear sRGB, (..., 3), to linear display values in 0..1."""
    v = np.minimum(
        CURVE_EXPOSURE * color @ ACES_INPUT.T, 1e8
    )  # the curve has reached its end, and squares stay far from overflow
    curved = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return np.clip(curved @ ACES_OUTPUT.T, 0.0, 1.0)


def encode_srgb(linear: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Linear 0..1 to sRGB 0..1: IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1.0 / 2.4) - 0.055)


def to_8_bit(values: npt.NDArray[np.floating]) -> npt.NDArray[np.uint8]:
    """0..1 as round(255 × value); values outside are clipped, NaN is 0."""
    return np.rint(255.0 * np.clip(np.nan_to_num(values), 0.0, 1.0)).astype(np.uint8)
