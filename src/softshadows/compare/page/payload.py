"""What the page's explorer draws from: pictures as files, visibility as 16-bit images, packed.

Errors are not stored. The page subtracts the truth from a visibility image, so an error map amplified a hundredfold
shows what was measured, and not the steps of an 8-bit picture.
"""

from __future__ import annotations

import base64
import io
import zlib
from collections.abc import Sequence
from statistics import fmean
from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows import metrics
from softshadows.compare.measure import Measurement, Result
from softshadows.metrics.leaks import OUTSIDE, TOO_DARK, TOO_LIGHT

FULL = 65535
"""Visibility 1 as a 16-bit number."""

WORST_SHARE, WORST_LEAST = 8, 24
"""The worst region's side: so many of them fit the picture's height, but at least so many pixels."""


def payload(measurements: Sequence[Measurement]) -> dict[str, Any]:
    """Plain data for page.js, which documents its shape by reading it."""
    colours = {"tooLight": TOO_LIGHT, "tooDark": TOO_DARK, "outside": OUTSIDE}
    return {
        "full": FULL,
        "colours": {name: np.rint(255 * colour).astype(int).tolist() for name, colour in colours.items()},
        "pictures": [_picture(measurement) for measurement in measurements],
    }


def worst_regions(measurement: Measurement, result: Result) -> list[metrics.Region | None]:
    """Where a technique errs most, light by light."""
    reference = measurement.reference
    side = max(measurement.shot.size[1] // WORST_SHARE, WORST_LEAST)
    images = zip(result.visibility, reference.visibility, reference.mask, strict=True)
    return [metrics.worst_region(*image, side=side) for image in images]


def pack_visibility(image: npt.NDArray[np.floating]) -> str:
    """(height, width) 0..1 as base64 of zlib of 16-bit numbers: differences from pixel to pixel, row by row.

    All high bytes come first, then all low bytes. A difference d is stored as 2d, or −2d − 1 where it is negative, so
    that small ones have a high byte of 0.
    """
    values = np.rint(FULL * np.clip(image, 0.0, 1.0)).astype(np.int32).ravel()
    steps = np.diff(values, prepend=0).astype(np.int16).astype(np.int32)  # modulo 65536, nearest to 0
    stored = np.where(steps >= 0, 2 * steps, -2 * steps - 1).astype(np.uint16)
    return _packed((stored >> 8).astype(np.uint8).tobytes() + (stored & 255).astype(np.uint8).tobytes())


def pack_mask(mask: npt.NDArray[np.bool_]) -> str:
    """(height, width) bool as base64 of zlib of bits, row by row, the first pixel in the highest bit."""
    return _packed(np.packbits(mask).tobytes())


def picture_uri(picture: npt.NDArray[np.uint8]) -> str:
    """(height, width, 3) uint8 as a lossless WebP file in a data URI: some 70 % of a PNG's bytes."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(stream, "WEBP", lossless=True, quality=80, method=4)
    return "data:image/webp;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def _packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _picture(measurement: Measurement) -> dict[str, Any]:
    shot, reference = measurement.shot, measurement.reference
    width, height = shot.size
    results = measurement.results
    return {
        "name": shot.name,
        "width": width,
        "height": height,
        "picture": picture_uri(reference.picture),
        "best": min(
            range(len(results)), key=lambda index: fmean(c.rmse for c in results[index].comparisons), default=None
        ),
        "lights": [
            {"name": f"light {index}, {light.kind}", "truth": pack_visibility(truth), "mask": pack_mask(mask)}
            for index, (light, truth, mask) in enumerate(
                zip(shot.scene.lights, reference.visibility, reference.mask, strict=True)
            )
        ],
        "techniques": [
            {
                "label": result.label,
                "picture": picture_uri(result.picture),
                "visibility": [pack_visibility(image) for image in result.visibility],
                "worst": [region and list(region[:4]) for region in worst_regions(measurement, result)],
            }
            for result in results
        ],
    }
