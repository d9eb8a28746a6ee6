"""Arrays to PNG files and data URIs."""

from __future__ import annotations

import base64
import io

import numpy as np
import numpy.typing as npt

from softshadows.image.display import to_8_bit


def png(image: npt.NDArray) -> bytes:
    """A PNG of `image`, (height, width) or (height, width, 3): uint8 as it is, floats clipped to 0..1 and scaled."""
    from PIL import Image

    stored = image if image.dtype == np.uint8 else to_8_bit(image)
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(stored)).save(stream, "PNG")
    return stream.getvalue()


def data_uri(image: bytes) -> str:
    """A PNG as text that a page can hold."""
    return "data:image/png;base64," + base64.b64encode(image).decode("ascii")
