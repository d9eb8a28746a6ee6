"""Alpha of a masked surface at a point: which parts of a triangle exist.

The one definition that rays and shaders share, so it is spelled out to the texel and computed in float32 in the order
given. A surface point exists where

    base_color.a × texture.a(u, v) × vertex colour.a ≥ alpha_cutoff

The texture is read at its full resolution (level 0), whatever the distance:

1. (u, v) = transform · (u, v, 1) of the texture's set of coordinates. v = 0 is the upper border of row 0.
2. Each coordinate is first reduced, so that any finite value is safe: repeat to u − ⌊u⌋, mirror to u − 2⌊u/2⌋,
   clamp to [0, 1].
3. x = u·width (y likewise). Nearest: texel ⌊x⌋. Bilinear: texels i = ⌊x − ½⌋ and i + 1, weighted 1 − f and f with
   f = x − ½ − i; first along u in both rows, then along v.
4. Texel indices outside the image wrap: repeat i mod n; mirror m = i mod 2n, then m or 2n − 1 − m; clamp to 0 … n − 1.

A shader that mirrors this must use `textureLoad`: the sampler's own bilinear weights have as few as eight bits.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.scene.model import Material, Texture, Wrap

Floats = npt.NDArray[np.float32]
Integers = npt.NDArray[np.int64]


def exists(material: Material, texcoords: Floats, colors: Floats) -> npt.NDArray[np.bool_]:
    """(n,) bool: whether points of `material` exist.

    texcoords (n, 4) float32 holds both sets side by side, colors (n, 4) float32 the vertex colours.
    """
    if material.alpha_cutoff is None:
        return np.ones(len(texcoords), bool)
    alpha = np.float32(material.base_color[3]) * colors[:, 3]
    if material.base_color_texture is not None:
        alpha = alpha * texture_alpha(material.base_color_texture, texcoords)
    return alpha >= np.float32(material.alpha_cutoff)


def texture_alpha(texture: Texture, texcoords: Floats) -> Floats:
    """(n,) float32 in 0..1: alpha of `texture` at `texcoords` (n, 4) float32, both sets side by side."""
    first = 2 * texture.texcoord
    uv = texcoords[:, first : first + 2]
    transform = np.asarray(texture.transform, np.float32)
    u = transform[0, 0] * uv[:, 0] + transform[0, 1] * uv[:, 1] + transform[0, 2]
    v = transform[1, 0] * uv[:, 0] + transform[1, 1] * uv[:, 1] + transform[1, 2]

    height, width = texture.pixels.shape[:2]
    x = _reduced(u, texture.wrap_u) * np.float32(width)
    y = _reduced(v, texture.wrap_v) * np.float32(height)
    if texture.nearest:
        return _texel(texture, np.floor(x).astype(np.int64), np.floor(y).astype(np.int64))

    x, y = x - np.float32(0.5), y - np.float32(0.5)
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, down = x - column.astype(np.float32), y - row.astype(np.float32)
    left, up = np.float32(1) - right, np.float32(1) - down
    upper = _texel(texture, column, row) * left + _texel(texture, column + 1, row) * right
    lower = _texel(texture, column, row + 1) * left + _texel(texture, column + 1, row + 1) * right
    return np.asarray(upper * up + lower * down, np.float32)


def _texel(texture: Texture, column: Integers, row: Integers) -> Floats:
    height, width = texture.pixels.shape[:2]
    alpha = texture.pixels[_wrapped(row, height, texture.wrap_v), _wrapped(column, width, texture.wrap_u), 3]
    return alpha.astype(np.float32) / np.float32(255)


def _reduced(u: Floats, wrap: Wrap) -> Floats:
    if wrap == "repeat":
        return u - np.floor(u)
    if wrap == "mirror":
        return u - 2 * np.floor(u / 2)
    return np.clip(u, 0, 1)


def _wrapped(index: Integers, size: int, wrap: Wrap) -> Integers:
    if wrap == "repeat":
        return index % size
    if wrap == "mirror":
        index = index % (2 * size)
        return np.minimum(index, 2 * size - 1 - index)
    return np.clip(index, 0, size - 1)
