"""Lights on the GPU: their records and the points that stand for them, and the table of specular lobes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from softshadows.gpu.compose import constant
from softshadows.gpu.layout import F32, U32, ArrayOfVec4f, Struct, Vec3f
from softshadows.scene import lights as scene_lights

_HERE = Path(__file__).parent
KINDS = {kind: constant("lights/radiance.wgsl", kind.upper()) for kind in scene_lights.LIGHT_CLASSES}
"""The shader's numbers of the lights' kinds."""


class Light(Struct):
    """A light as every pass reads it (light.wgsl): world space, metres; it emits along -back.

    `kind` is one of KINDS; `index` is the light's place among the frame's lights, and so that of its visibility;
    emission has the unit of its kind (scene/lights.py); the cosines are of a spot's two angles. A directional light has
    no place and its rays are parallel; a round one fills an ellipse, not a rectangle; a flat one is a surface in its
    plane.
    """

    center_ws: Vec3f
    kind: U32
    right_ws: Vec3f
    half_width: F32
    up_ws: Vec3f
    half_height: F32
    back_ws: Vec3f
    is_one_sided: U32
    emission: Vec3f
    index: U32
    is_directional: U32
    is_round: U32
    is_flat: U32
    cos_inner: F32
    cos_outer: F32


class LightSamples(Struct):
    """The points that stand for a light: x, y in light space, weight, 0.

    A sample may have several places by pixel (jitter.py): they follow each other in `points`, each with all `count`.
    """

    count: U32
    total_weight: F32  # of the `count` samples
    points: ArrayOfVec4f


class Chunk(Struct):
    """The samples of one dispatch or draw."""

    first_sample: U32
    sample_count: U32


def light_record(light: scene_lights.Light, index: int = 0) -> Light:
    """The record of a scene's light, of which the frame's visibility is number `index`."""
    right, up, back = light.axes.tolist()
    inner, outer = light.cone
    return Light(
        center_ws=tuple(light.center.tolist()),
        kind=KINDS[light.kind],
        right_ws=tuple(right),
        half_width=light.half_extent[0],
        up_ws=tuple(up),
        half_height=light.half_extent[1],
        back_ws=tuple(back),
        is_one_sided=int(light.one_sided),
        emission=light.emission,
        index=index,
        is_directional=int(light.is_directional),
        is_round=int(light.is_round),
        is_flat=int(light.is_flat),
        cos_inner=float(np.cos(np.radians(inner))),
        cos_outer=float(np.cos(np.radians(outer))),
    )


def samples_record(points: npt.NDArray[np.floating], weights: npt.NDArray[np.floating]) -> LightSamples:
    """n samples as the GPU reads them: `points` (places × n, 2), metres of light space, and their `weights` (n,)."""
    rows = np.zeros((len(points), 4), np.float32)
    rows[:, :2], rows[:, 2] = points, np.tile(weights, len(points) // len(weights))
    return LightSamples(count=len(weights), total_weight=float(np.sum(weights)), points=rows)


def specular_tables() -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """The fitted lobes of benchmarks/fit_ltc.py as two images, rows by view angle and columns by roughness.

    (64, 64, 4) float32, the inverse matrix's entries a, b, c, d, for a texture of format rgba32float; and (64, 64, 2)
    float32, the albedo for Fresnel 1 and for Fresnel (1 - v·h)⁵, for rg32float.
    """
    table = np.load(_HERE / "ltc.npy", allow_pickle=False)
    return np.ascontiguousarray(table[..., :4]), np.ascontiguousarray(table[..., 4:])
