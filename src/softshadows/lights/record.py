"""What the lighting pass reads besides the G-buffer: the lights as records, and the table of specular lobes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from softshadows.gpu.layout import F32, U32, Struct, Vec3f
from softshadows.scene import lights as scene_lights

_HERE = Path(__file__).parent
_KINDS = ("rect", "disk", "line", "point", "spot", "directional")


class Light(Struct):
    """A light as area_light.wgsl reads it: world space, metres; it emits along -back.

    `kind` counts rect, disk, line, point, spot, directional; emission has the unit of its kind (scene/lights.py);
    the cosines are of a spot's two angles.
    """

    position_ws: Vec3f
    kind: U32
    right_ws: Vec3f
    half_width: F32
    up_ws: Vec3f
    half_height: F32
    back_ws: Vec3f
    two_sided: U32
    emission: Vec3f
    cos_inner: F32
    cos_outer: F32


def light_record(light: scene_lights.Light) -> Light:
    """The record of a scene's light."""
    right, up, back = light.axes.tolist()
    inner, outer = (light.inner_angle, light.outer_angle) if isinstance(light, scene_lights.SpotLight) else (0.0, 90.0)
    return Light(
        position_ws=tuple(light.center.tolist()),
        kind=_KINDS.index(light.kind),
        right_ws=tuple(right),
        half_width=light.half_extent[0],
        up_ws=tuple(up),
        half_height=light.half_extent[1],
        back_ws=tuple(back),
        two_sided=int(not light.one_sided),
        emission=light.emission,
        cos_inner=float(np.cos(np.radians(inner))),
        cos_outer=float(np.cos(np.radians(outer))),
    )


def specular_tables() -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """The fitted lobes of benchmarks/fit_ltc.py as two images, rows by view angle and columns by roughness.

    (64, 64, 4) float32, the inverse matrix's entries a, b, c, d, for a texture of format rgba32float; and (64, 64, 2)
    float32, the albedo for Fresnel 1 and for Fresnel (1 - v·h)⁵, for rg32float.
    """
    table = np.load(_HERE / "ltc.npy", allow_pickle=False)
    return np.ascontiguousarray(table[..., :4]), np.ascontiguousarray(table[..., 4:])
