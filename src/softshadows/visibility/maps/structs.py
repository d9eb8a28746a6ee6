"""What shadow maps share with their shaders: their settings, windows and draws."""

from __future__ import annotations

from softshadows.gpu.compose import constant
from softshadows.gpu.layout import F32, U32, Struct, Vec2f, Vec2u, Vec4f

FACES = constant("visibility/maps/light_space.wgsl", "FACES")
"""Faces of the cube around a light sample that its windows are cut into."""


class MapSettings(Struct):
    """How the maps of a light's samples see, and how they share the atlas (light_space.wgsl, placing.wgsl).

    A uniform: only the depths and scales in its first row change with the light, and no shader branches on those.
    """

    near: F32  # metres
    far: F32
    depth_scale: F32  # stored depth over inverse depth
    window_scale: F32  # metres that windows are measured in: 1 where they are in tangents
    texels_per_pixel: F32
    margin_texels: F32
    search_margin: F32  # half lights around the receivers that look-ups reach
    is_auto: U32
    tile_size: U32
    tiles_per_row: U32
    atlas_size: U32
    samples_per_batch: U32
    samples_per_chunk: U32


class ShadowView(Struct):
    """One window of one sample: where it lies in its face's tangents, and where in the atlas. Size 0: not in use."""

    window_low: Vec2f
    texels_per_unit: Vec2f
    origin: Vec2u
    size: Vec2u


class DrawView(Struct):
    """A view as its draw sees it: rows that take a world position, relative to the light's centre, to clip space.

    x and y run from 0 to 2 across the atlas once divided by w; `edges` are the view's low and high corner so.
    """

    row_x: Vec4f
    row_y: Vec4f
    row_inverse_depth: Vec4f
    row_w: Vec4f
    edges: Vec4f
