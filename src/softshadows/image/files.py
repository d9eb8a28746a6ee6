"""Pictures and data to files. A file appears whole or not at all.

.png    the picture, display transformed (display.py)
.exr    every image by name, float32: color.R color.G color.B, position.X ..., normal.X ..., depth, surface,
        visibility.0 visibility.1 ..., facing.0 ...; booleans are 0 and 1
.npz    the same arrays as they are: color, visibility, position, normal, depth, surface, facing
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenEXR
from PIL import Image

from softshadows.errors import OptionError
from softshadows.image.display import display, to_8_bit

SUFFIXES = (".png", ".exr", ".npz")

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]


def save_frame(
    path: str | os.PathLike[str],
    *,
    color: Float,
    visibility: Float,
    position: Float,
    normal: Float,
    depth: Float,
    surface: Bool,
    facing: Bool,
    exposure: float | None = None,
) -> None:
    """Write a frame's images; the suffix of `path` chooses the format.

    color, position and normal are (height, width, 3), depth and surface (height, width), visibility and facing
    (lights, height, width). `exposure` (stops, None is automatic) matters to .png only. A file or symbolic link at
    `path` is replaced; a link's target is left alone. Raises OptionError for another suffix, a missing folder, or a
    folder at `path`.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    images = {
        "color": color,
        "visibility": visibility,
        "position": position,
        "normal": normal,
        "depth": depth,
        "surface": surface,
        "facing": facing,
    }
    if suffix == ".png":
        picture = Image.fromarray(display(color, exposure=exposure))
        replace_file(path, lambda part: picture.save(part, format="PNG"))
    elif suffix == ".exr":
        replace_file(path, lambda part: _write_exr(part, _channels(images)))
    elif suffix == ".npz":
        replace_file(path, lambda part: np.savez_compressed(part, allow_pickle=False, **images))
    else:
        raise OptionError(f"{path.name!r}: the suffix must be one of {', '.join(SUFFIXES)}, got {path.suffix!r}")


def save_png(path: str | os.PathLike[str], values: Float | npt.NDArray[np.uint8]) -> None:
    """Write an image of data: a stored byte is round(255 × value), without any display transform; uint8 stays as it is.

    `values` is (height, width), grey, or (height, width, 3); values outside 0..1 are clipped. So a visibility image
    can be read back to within 1/510. Raises OptionError as save_frame, and for another shape.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise OptionError(f"{path.name!r}: the suffix must be .png, got {path.suffix!r}")
    if not (values.ndim == 2 or (values.ndim == 3 and values.shape[2] == 3)):
        raise OptionError(f"an image must have the shape (height, width) or (height, width, 3), got {values.shape}")
    stored = values if values.dtype == np.uint8 else to_8_bit(values.astype(np.float64))
    picture = Image.fromarray(np.ascontiguousarray(stored))
    replace_file(path, lambda part: picture.save(part, format="PNG"))


def _channels(images: dict[str, npt.NDArray]) -> dict[str, npt.NDArray[np.float32]]:
    """One contiguous (height, width) float32 array per EXR channel; OpenEXR writes any other memory layout wrong."""
    channels = {}
    for name, image in images.items():
        if image.ndim == 2:
            parts = {name: image}
        elif name in ("visibility", "facing"):
            parts = {f"{name}.{light}": part for light, part in enumerate(image)}
        else:
            letters = "RGB" if name == "color" else "XYZ"
            parts = {f"{name}.{letter}": image[..., index] for index, letter in enumerate(letters)}
        for part_name, part in parts.items():
            channels[part_name] = np.ascontiguousarray(part, np.float32)
    return channels


def _write_exr(path: Path, channels: dict[str, npt.NDArray[np.float32]]) -> None:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a new file beside `path`, then put it in its place in one step."""
    if not path.parent.is_dir():
        raise OptionError(f"cannot write {path.name!r}: the folder {str(path.parent)!r} does not exist")
    if path.is_dir() and not path.is_symlink():
        raise OptionError(f"cannot write {str(path)!r}: it is a folder")
    part = path.with_name(f".{path.stem}.{secrets.token_hex(8)}{path.suffix.lower()}")
    try:
        write(part)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
