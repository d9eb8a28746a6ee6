"""All textures of a scene in one array texture: mip chains packed onto pages, sampled by our own code in texture.wgsl.

Core WebGPU has no bindless textures, and images come in any size with their own wrap modes, so each image's mip chain
is a rectangle on a page: level 0 at its origin, the smaller levels in a column to its right.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from PIL import Image

from softshadows.errors import DeviceError
from softshadows.gpu.layout import U32, Struct, Vec2u, Vec3f
from softshadows.scene.model import Texture

_WRAPS = {"repeat": 0, "mirror": 1, "clamp": 2}
_MOST_PAGES = 256  # WebGPU's default maxTextureArrayLayers


class TextureRecord(Struct):
    """Where a texture's level 0 lies and how it is read. `transform_u`, `transform_v` map (u, v, 1)."""

    transform_u: Vec3f
    page: U32
    transform_v: Vec3f
    levels: U32
    origin: Vec2u
    size: Vec2u
    wrap_u: U32
    wrap_v: U32
    nearest: U32
    texcoord: U32


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Sizes of the mip levels down to 1×1."""
    sizes = [(width, height)]
    while sizes[-1] != (1, 1):
        w, h = sizes[-1]
        sizes.append((max(w // 2, 1), max(h // 2, 1)))
    return sizes


def _footprint(width: int, height: int) -> tuple[int, int]:
    """Size of the rectangle that holds the whole chain."""
    small = level_sizes(width, height)[1:]
    return width + (small[0][0] if small else 0), max(height, sum(h for _, h in small))


def _mip_chain(pixels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """The chain in one image, box filtered in 8 bits."""
    height, width = pixels.shape[:2]
    total_width, total_height = _footprint(width, height)
    chain = np.zeros((total_height, total_width, 4), np.uint8)
    chain[:height, :width] = pixels
    image, y = Image.fromarray(pixels, "RGBA"), 0
    for w, h in level_sizes(width, height)[1:]:
        image = image.resize((w, h), Image.Resampling.BOX)
        chain[y : y + h, width : width + w] = np.asarray(image)
        y += h
    return chain


def build_pages(
    textures: Sequence[Texture], largest_page: int
) -> tuple[npt.NDArray[np.uint8], list[TextureRecord], list[str]]:
    """Pages (n, size, size, 4) uint8, one record per texture, and warnings for images that had to be reduced.

    Images shared by several textures are stored once. Shelf packing, tallest first.
    """
    warnings: list[str] = []
    chains: dict[int, npt.NDArray[np.uint8]] = {}
    level_0: dict[int, tuple[int, int]] = {}
    for texture in textures:
        key = id(texture.pixels)
        if key in chains:
            continue
        pixels = np.ascontiguousarray(texture.pixels)
        while max(_footprint(pixels.shape[1], pixels.shape[0])) > largest_page:
            height, width = pixels.shape[:2]
            warnings.append(f"texture {texture.name!r} ({width}×{height}) exceeds the adapter's limit and was halved")
            half = (max(width // 2, 1), max(height // 2, 1))
            pixels = np.asarray(Image.fromarray(pixels, "RGBA").resize(half, Image.Resampling.BOX))
        chains[key], level_0[key] = _mip_chain(pixels), (pixels.shape[1], pixels.shape[0])

    widest = max((max(chain.shape[:2]) for chain in chains.values()), default=1)
    page_size = min(largest_page, max(1 << (widest - 1).bit_length(), 1))
    places: dict[int, tuple[int, int, int]] = {}
    page = x = y = shelf = 0
    for key, chain in sorted(chains.items(), key=lambda item: -item[1].shape[0]):
        height, width = chain.shape[:2]
        if x + width > page_size:
            x, y, shelf = 0, y + shelf, 0
        if y + height > page_size:
            page, x, y, shelf = page + 1, 0, 0, 0
        places[key] = (page, x, y)
        x, shelf = x + width, max(shelf, height)
    if page >= _MOST_PAGES:
        raise DeviceError(
            f"the textures need {page + 1} pages of {page_size}², the adapter has {_MOST_PAGES}; use smaller textures"
        )

    pages = np.zeros((page + 1, page_size, page_size, 4), np.uint8)
    for key, (p, x, y) in places.items():
        chain = chains[key]
        pages[p, y : y + chain.shape[0], x : x + chain.shape[1]] = chain
    records = []
    for texture in textures:
        p, x, y = places[id(texture.pixels)]
        width, height = level_0[id(texture.pixels)]
        row_u, row_v = np.asarray(texture.transform, np.float64)
        records.append(
            TextureRecord(
                transform_u=tuple(row_u),
                page=p,
                transform_v=tuple(row_v),
                levels=len(level_sizes(width, height)),
                origin=(x, y),
                size=(width, height),
                wrap_u=_WRAPS[texture.wrap_u],
                wrap_v=_WRAPS[texture.wrap_v],
                nearest=int(texture.nearest),
                texcoord=texture.texcoord,
            )
        )
    return pages, records, warnings
