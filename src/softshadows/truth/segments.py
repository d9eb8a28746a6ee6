"""The segments that decide what a pixel sees of a light: from just off its surface to points of the light.

Rays start a few ULP off the receiver along its normal, and end as far before a flat light, so that neither a receiver
shadows itself nor a lamp's own luminous face its light (see `tracer.OFFSET`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.scene.lights import Light
from softshadows.truth.tracer import NOT_ASKED, Array, Bools, Floats, Tracer


class Surfaces(Protocol):
    """What a frame must show: see `truth.visibility`."""

    @property
    def position(self) -> npt.NDArray[Any]: ...
    @property
    def normal(self) -> npt.NDArray[Any]: ...
    @property
    def surface(self) -> npt.NDArray[Any]: ...


@dataclass(frozen=True)
class Receivers:
    """The pixels that show a surface: position and normal (n, 3) float64, world space, and their place in the image."""

    position: Array
    normal: Array
    surface: Bools

    @classmethod
    def of(cls, frame: Surfaces) -> Receivers:
        """Those of a frame; OptionError for one that is none."""
        position, normal, surface = (np.asarray(getattr(frame, name)) for name in ("position", "normal", "surface"))
        if surface.ndim != 2 or surface.dtype != np.bool_:
            raise OptionError(f"frame.surface must be (height, width) bool, got {surface.shape} {surface.dtype}")
        for name, values in (("position", position), ("normal", normal)):
            if values.shape != (*surface.shape, 3) or not np.issubdtype(values.dtype, np.floating):
                raise OptionError(
                    f"frame.{name} must be {(*surface.shape, 3)} float32, got {values.shape} {values.dtype}"
                )
        position, normal = position[surface].astype(np.float64), normal[surface].astype(np.float64)
        if not np.isfinite(position).all():
            raise OptionError("frame.position must be finite wherever frame.surface is true")
        if not np.all(np.abs(np.linalg.norm(normal, axis=1) - 1.0) < 1e-3):  # also refuses NaN
            raise OptionError("frame.normal must have length 1 wherever frame.surface is true")
        return cls(position, normal, surface)

    @property
    def count(self) -> int:
        return len(self.position)

    def __getitem__(self, rows: slice) -> Receivers:
        return Receivers(self.position[rows], self.normal[rows], self.surface)

    def image(self, values: npt.NDArray[Any], fill: float) -> npt.NDArray[Any]:
        """`values` (layers, n) as (layers, height, width), with `fill` where there is no surface."""
        result = np.full((len(values), *self.surface.shape), fill, values.dtype)
        result[:, self.surface] = values
        return result


@dataclass(frozen=True, eq=False)
class Segments:
    """From start (n, 3) float64 along the share `t_max` (n, k) of rays (n, k, 3), float32: k from each receiver.

    `t_max` is NOT_ASKED where the light point lies below the receiver's horizon, or the receiver behind the light.
    """

    start: Array
    rays: Floats
    t_max: Floats

    def visible(self, tracer: Tracer) -> Bools:
        """(n, k): those that end at light."""
        return ~tracer.blocked_from(self.start, self.rays, self.t_max)


def cells_of(light: Light, samples: int) -> tuple[int, int]:
    """Cells along the light's two axes, at least `samples` in all, about as wide as high."""
    a, b = light.half_extent
    if a == 0.0 and b == 0.0:
        return (1, 1)
    if b == 0.0:
        return (samples, 1)
    if a == 0.0:
        return (1, samples)
    columns = int(np.clip(round(np.sqrt(samples * a / b)), 1, samples))
    return (columns, -(-samples // columns))


def stratified(
    light: Light, cells: tuple[int, int], receivers: Receivers, tracer: Tracer, random: np.random.Generator
) -> Segments:
    """To one random point in each cell of the light, row by row."""
    start = _start(receivers, tracer)
    return _cut(light, receivers, start, _rays(light, cells, start, tracer, random), tracer)


def to_points(points: npt.NDArray[Any], light: Light | None, receivers: Receivers, tracer: Tracer) -> Segments:
    """To each of `points` (k, 3), world space, which lie on `light` where one is given."""
    start = _start(receivers, tracer)
    return _cut(light, receivers, start, (points - start[:, None, :]).astype(np.float32), tracer)


def _start(receivers: Receivers, tracer: Tracer) -> Array:
    """(n, 3) float64: where rays leave, clear of the surface."""
    return receivers.position + tracer.offset(receivers.position)[:, None] * receivers.normal


def _rays(light: Light, cells: tuple[int, int], start: Array, tracer: Tracer, random: np.random.Generator) -> Floats:
    """(n, k, 3) float32: from each `start` to the light."""
    if light.is_directional:
        reach = np.linalg.norm(start - tracer.center, axis=1) + tracer.diagonal + 1.0  # past all triangles
        return (reach[:, None, None] * light.axes[2]).astype(np.float32)
    if not light.has_size:
        return (light.center - start)[:, None, :].astype(np.float32)

    columns, rows = cells
    s, t = random.random((2, len(start), rows, columns), np.float32)
    s = ((s + np.arange(columns, dtype=np.float32)) / np.float32(columns)).reshape(len(start), -1)
    t = ((t + np.arange(rows, dtype=np.float32)[:, None]) / np.float32(rows)).reshape(len(start), -1)
    if light.is_round:
        return (light.points(s, t) - start[:, None, :]).astype(np.float32)
    corner, right, top = light.points(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    rays = np.empty((*s.shape, 3), np.float32)
    for axis in range(3):  # rectangles and lines are affine in (s, t); three long loops beat many of length three
        rays[..., axis] = (
            np.float32(right[axis] - corner[axis]) * s
            + np.float32(top[axis] - corner[axis]) * t
            + (corner[axis] - start[:, axis, None]).astype(np.float32)
        )
    return rays


def _cut(light: Light | None, receivers: Receivers, start: Array, rays: Floats, tracer: Tracer) -> Segments:
    """The part of each ray that counts: none below the horizon or behind the light, and not the light's own face."""
    offset = tracer.offset(receivers.position)
    above = np.matmul(rays, receivers.normal[:, :, None].astype(np.float32))[..., 0]  # of the start's horizon
    asked = above > -offset[:, None]
    height = np.zeros(receivers.count) if light is None else (receivers.position - light.center) @ -light.axes[2]
    if light is not None and light.one_sided:
        asked &= height[:, None] > 0.0
    t_max: npt.ArrayLike = 1.0
    if light is not None and light.is_flat:
        t_max = 1.0 - tracer.offset(light.center) / np.maximum(np.abs(height), 1e-30)[:, None]
    elif light is None or not light.is_directional:
        t_max = 1.0 - offset[:, None] / np.maximum(np.linalg.norm(rays, axis=2), 1e-30)
    return Segments(start, rays, np.where(asked, np.maximum(t_max, 0.0), NOT_ASKED).astype(np.float32))
