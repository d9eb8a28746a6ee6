"""Encoded images (PNG, JPEG, WebP) to (height, width, 4) uint8 by Pillow, with limits checked before decoding."""

from __future__ import annotations

import hashlib
import io
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

from softshadows.errors import SceneError
from softshadows.scene.load.budget import MEBIBYTE, Budget

Pixels = npt.NDArray[np.uint8]

MAX_SIDE = 16384
MAX_PIXELS = 2**27

# Photographs compress to 1/10 .. 1/100 of their pixels, flat colours to 1/1000: small images may do that, big ones may
# not.
TOTAL_FLOOR_MEBIBYTES, SINGLE_FLOOR_MEBIBYTES, FACTOR = 192, 64, 128

TOLERATED_CODES = ("IMAGE_MISSING", "IMAGE_INVALID", "IMAGE_TOO_BIG", "URI_SCHEME", "URI_OUTSIDE_FOLDER", "INVALID_URI")
"""Errors of an image that `on_missing="warn"` turns into warnings; none of them reads what it should not."""

DECODING_THREADS = 2
"""More would hold more half-decoded images in memory at a time; Pillow releases the interpreter while it decodes."""


@dataclass(frozen=True)
class EncodedImage:
    """Bytes of an image file, and where an error in it is reported."""

    data: bytes
    file: str
    pointer: str | None = None

    def error(self, code: str, message: str) -> SceneError:
        return SceneError(message, code=code, file=self.file, pointer=self.pointer)


def decode_images(images: list[EncodedImage], on_missing: str) -> list[Pixels | SceneError]:
    """The pixels of each image, in order, or its SceneError; identical bytes give the identical array.

    Codes: IMAGE_TOO_BIG for more than 16384 pixels a side, 2²⁷ in all, or out of proportion to the encoded size;
    IMAGE_INVALID for bytes that do not decode. With `on_missing="error"` an image whose header is refused raises its
    error before any is decoded.
    """
    budget = Budget.for_file(
        sum(len(image.data) for image in images), floor_mebibytes=TOTAL_FLOOR_MEBIBYTES, factor=FACTOR
    )
    digests = [hashlib.blake2b(image.data).digest() for image in images]
    opened: dict[bytes, Image.Image | SceneError] = {}
    for digest, image in zip(digests, images, strict=True):
        if digest not in opened:
            opened[digest] = _open(image, budget)
    refused = [image for image in opened.values() if isinstance(image, SceneError)]
    if refused and on_missing == "error":
        raise refused[0]
    sources = {digest: image for digest, image in zip(digests, images, strict=True)}
    with ThreadPoolExecutor(DECODING_THREADS) as pool:
        decoded = pool.map(lambda digest: _pixels(opened[digest], sources[digest]), opened)
        results = dict(zip(opened, decoded, strict=True))
    return [results[digest] for digest in digests]


def _open(source: EncodedImage, budget: Budget) -> Image.Image | SceneError:
    """The image with its header read and its size within the limits."""
    try:
        with warnings.catch_warnings():  # our own limit is below the size at which Pillow refuses
            warnings.simplefilter("ignore")
            image = Image.open(io.BytesIO(source.data), formats=("PNG", "JPEG", "WEBP"))
    except Image.DecompressionBombError as error:
        return source.error("IMAGE_TOO_BIG", str(error))
    except Exception as error:  # Pillow raises almost any class for a corrupt header
        return source.error("IMAGE_INVALID", f"not a PNG, JPEG or WebP image: {_reason(error)}")
    width, height = image.size
    size = 4 * width * height
    fits_alone = size <= SINGLE_FLOOR_MEBIBYTES * MEBIBYTE + FACTOR * len(source.data)
    if max(width, height) > MAX_SIDE or width * height > MAX_PIXELS:
        return source.error(
            "IMAGE_TOO_BIG", f"{width} × {height} pixels exceed {MAX_SIDE} a side or {MAX_PIXELS} in all"
        )
    if not fits_alone or not budget.spend(size):
        message = f"{width} × {height} pixels are out of proportion to {len(source.data)} encoded bytes"
        return source.error("IMAGE_TOO_BIG", message)
    return image


def _pixels(image: Image.Image | SceneError, source: EncodedImage) -> Pixels | SceneError:
    if isinstance(image, SceneError):
        return image
    try:
        if image.mode.startswith("I"):  # 16-bit grey, which Pillow's own conversion would clip
            grey = (np.asarray(image).astype(np.uint32) >> 8).clip(0, 255).astype(np.uint8)
            return np.stack([grey, grey, grey, np.full_like(grey, 255)], axis=-1)
        return np.array(image if image.mode == "RGBA" else image.convert("RGBA"), np.uint8)
    except Exception as error:  # as in _open
        return source.error("IMAGE_INVALID", f"the image is corrupt: {_reason(error)}")
    finally:
        image.close()  # frees Pillow's copy of the pixels


def _reason(error: Exception) -> str:
    return str(error)[:200] or type(error).__name__
