"""The lights: rectangles, disks and lines that cast soft shadows, and the zero-size lights of glTF.

Every light has a local frame (rows right, up, back; it emits along −back), a centre and a half extent, and maps the
unit square onto its surface. That is all that samplers, shadow maps and truth need to know of its shape.

Units: metres; `radiance` in W/(m² sr) for surfaces, W/(m sr) for lines (the radiant intensity of one metre seen from
the side); `intensity` in W/sr; `irradiance` in W/m². RGB, linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError
from softshadows.scene.vectors import Array, Vector, look_at, number, vector

MAX_RADIANCE = 1e9
MAX_EXTENT = 1e6


def _set(light: object, **values: object) -> None:
    for name, value in values.items():
        object.__setattr__(light, name, value)


def _color(value: object, name: str, owner: str) -> Vector:
    color = vector(value, name, owner, limit=MAX_RADIANCE)
    if min(color) < 0.0:
        raise SceneError(
            f"{owner}: {name} must not be negative, got {value!r}", code="VALUE_NOT_IN_RANGE", pointer=name
        )
    return color


def _check_apart(a: Vector, b: Vector, name: str, owner: str) -> None:
    if a == b:
        raise SceneError(f"{owner}: position and {name} must differ", code="LOOK_AT_DEGENERATE", pointer=name)


@dataclass(frozen=True)
class Light:
    """What all lights share. Use one of the subclasses."""

    kind: ClassVar[str] = ""
    one_sided: ClassVar[bool] = False
    """True where the light emits only into the half space before it (a property of rectangles and disks)."""

    @property
    def center(self) -> Array:
        """(3,) float64, world space."""
        raise NotImplementedError

    @property
    def axes(self) -> Array:
        """Rows right, up, back: (3, 3) float64, world space; the light emits along −back."""
        raise NotImplementedError

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half width along right and half height along up, metres; (0, 0) for a light without size."""
        return (0.0, 0.0)

    @property
    def emission(self) -> Vector:
        """Radiance, intensity or irradiance, after the light's kind."""
        raise NotImplementedError

    @property
    def without_size(self) -> Light:
        """The light shrunk to its centre, as one of the same kind."""
        return self

    def points(self, s: Array, t: Array) -> Array:
        """World positions, (..., 3) float64, of points (s, t) of the unit square; equal areas map to equal areas."""
        s, t = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(t, np.float64))
        x, y = self._local(2.0 * s - 1.0, 2.0 * t - 1.0)
        right, up, _ = self.axes
        return self.center + x[..., None] * right + y[..., None] * up

    def _local(self, x: Array, y: Array) -> tuple[Array, Array]:
        a, b = self.half_extent
        return a * x, b * y


@dataclass(frozen=True)
class RectLight(Light):
    """A rectangle centred at `position`, emitting towards `target`; width runs along its right, height along its up.

    A width or height of zero is legal and gives a zero-size light. Raises SceneError for values that are not finite,
    negative sizes or radiance, and position = target.
    """

    position: Vector
    target: Vector
    width: float
    height: float
    radiance: Vector
    two_sided: bool = False
    up: Vector | None = None

    kind: ClassVar[str] = "rect"

    def __post_init__(self) -> None:
        name = type(self).__name__
        _set(
            self,
            position=vector(self.position, "position", name),
            target=vector(self.target, "target", name),
            width=number(self.width, "width", name, 0.0, MAX_EXTENT),
            height=number(self.height, "height", name, 0.0, MAX_EXTENT),
            radiance=_color(self.radiance, "radiance", name),
            two_sided=bool(self.two_sided),
            up=None if self.up is None else vector(self.up, "up", name),
        )
        _check_apart(self.position, self.target, "target", name)

    @property
    def one_sided(self) -> bool:  # type: ignore[override]
        return not self.two_sided

    @property
    def center(self) -> Array:
        return np.asarray(self.position)

    @property
    def axes(self) -> Array:
        return look_at(self.position, self.target, self.up)

    @property
    def half_extent(self) -> tuple[float, float]:
        return (self.width / 2.0, self.height / 2.0)

    @property
    def without_size(self) -> RectLight:
        return replace(self, width=0.0, height=0.0)

    @property
    def emission(self) -> Vector:
        return self.radiance


@dataclass(frozen=True)
class DiskLight(Light):
    """A disk of `radius` centred at `position`, emitting towards `target`. Errors as RectLight."""

    position: Vector
    target: Vector
    radius: float
    radiance: Vector
    two_sided: bool = False

    kind: ClassVar[str] = "disk"

    def __post_init__(self) -> None:
        _set(
            self,
            position=vector(self.position, "position", "DiskLight"),
            target=vector(self.target, "target", "DiskLight"),
            radius=number(self.radius, "radius", "DiskLight", 0.0, MAX_EXTENT),
            radiance=_color(self.radiance, "radiance", "DiskLight"),
            two_sided=bool(self.two_sided),
        )
        _check_apart(self.position, self.target, "target", "DiskLight")

    @property
    def one_sided(self) -> bool:  # type: ignore[override]
        return not self.two_sided

    @property
    def center(self) -> Array:
        return np.asarray(self.position)

    @property
    def axes(self) -> Array:
        return look_at(self.position, self.target)

    @property
    def half_extent(self) -> tuple[float, float]:
        return (self.radius, self.radius)

    @property
    def without_size(self) -> DiskLight:
        return replace(self, radius=0.0)

    @property
    def emission(self) -> Vector:
        return self.radiance

    def _local(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The concentric map of Shirley and Chiu (1997): squares become circles, areas keep their ratio."""
        outer = np.where(np.abs(x) > np.abs(y), x, y)
        safe = np.where(outer == 0.0, 1.0, outer)
        angle = np.where(np.abs(x) > np.abs(y), (np.pi / 4.0) * y / safe, np.pi / 2.0 - (np.pi / 4.0) * x / safe)
        return self.radius * outer * np.cos(angle), self.radius * outer * np.sin(angle)


@dataclass(frozen=True)
class LineLight(Light):
    """A straight segment of zero radius from `start` to `end`, emitting all around. Errors as RectLight."""

    start: Vector
    end: Vector
    radiance: Vector

    kind: ClassVar[str] = "line"

    def __post_init__(self) -> None:
        _set(
            self,
            start=vector(self.start, "start", "LineLight"),
            end=vector(self.end, "end", "LineLight"),
            radiance=_color(self.radiance, "radiance", "LineLight"),
        )

    @classmethod
    def outline(cls, corners: Sequence[Vector], radiance: Vector) -> list[LineLight]:
        """The sides of a flat polygon as lines that together shine as brightly along its normal as the polygon would.

        `corners` (n, 3), n ≥ 3, world space, in order around it; `radiance` its own, W/(m² sr). Heidrich, Brabec and
        Seidel (2000, §4) shadow a triangular light by its three sides so. It is a crude stand-in: lines shine all
        around, and shadows lack what the polygon's inside adds. Raises SceneError for a polygon without area.
        """
        points = np.array([vector(corner, f"corners[{index}]", "outline") for index, corner in enumerate(corners)])
        points = points.reshape(-1, 3)
        spokes = points[1:] - points[:1]
        area = float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))) / 2.0
        if not area > 0.0:
            raise SceneError(
                f"outline: corners must be three or more points around an area, got {corners!r}",
                code="VALUE_NOT_IN_RANGE",
                pointer="corners",
            )
        following = np.roll(points, -1, axis=0)
        perimeter = float(np.linalg.norm(following - points, axis=1).sum())
        emission = tuple(area / perimeter * channel for channel in _color(radiance, "radiance", "outline"))
        sides = zip(points.tolist(), following.tolist(), strict=True)
        return [cls(tuple(start), tuple(end), emission) for start, end in sides]  # type: ignore[arg-type]

    @property
    def center(self) -> Array:
        return (np.asarray(self.start) + np.asarray(self.end)) / 2.0

    @property
    def axes(self) -> Array:
        """right runs from start to end; −back is the direction closest to straight down."""
        right = np.asarray(self.end) - np.asarray(self.start)
        length = np.linalg.norm(right)
        right = right / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
        reference = np.array([0.0, 1.0, 0.0]) if abs(right[1]) < 0.999 else np.array([0.0, 0.0, 1.0])
        back = reference - right * (right @ reference)
        back /= np.linalg.norm(back)
        return np.stack([right, np.cross(back, right), back])

    @property
    def half_extent(self) -> tuple[float, float]:
        return (float(np.linalg.norm(np.subtract(self.end, self.start))) / 2.0, 0.0)

    @property
    def without_size(self) -> LineLight:
        middle = tuple(self.center.tolist())
        return replace(self, start=middle, end=middle)

    @property
    def emission(self) -> Vector:
        return self.radiance


@dataclass(frozen=True)
class PointLight(Light):
    """A light without size at `position`, emitting `intensity` (W/sr) all around."""

    position: Vector
    intensity: Vector

    kind: ClassVar[str] = "point"

    def __post_init__(self) -> None:
        _set(
            self,
            position=vector(self.position, "position", "PointLight"),
            intensity=_color(self.intensity, "intensity", "PointLight"),
        )

    @property
    def center(self) -> Array:
        return np.asarray(self.position)

    @property
    def axes(self) -> Array:
        return look_at((0.0, 0.0, 0.0), (0.0, -1.0, 0.0))

    @property
    def emission(self) -> Vector:
        return self.intensity


@dataclass(frozen=True)
class SpotLight(Light):
    """A point light with a cone to `target`: full `intensity` (W/sr) within `inner_angle`, none beyond `outer_angle`.

    Angles in degrees from the axis, 0 ≤ inner < outer ≤ 90; between them the smooth fall-off of KHR_lights_punctual.
    """

    position: Vector
    target: Vector
    intensity: Vector
    inner_angle: float = 0.0
    outer_angle: float = 45.0

    kind: ClassVar[str] = "spot"

    def __post_init__(self) -> None:
        _set(
            self,
            position=vector(self.position, "position", "SpotLight"),
            target=vector(self.target, "target", "SpotLight"),
            intensity=_color(self.intensity, "intensity", "SpotLight"),
            outer_angle=number(self.outer_angle, "outer_angle", "SpotLight", 0.0, 90.0, open_low=True),
        )
        _set(self, inner_angle=number(self.inner_angle, "inner_angle", "SpotLight", 0.0, self.outer_angle))
        _check_apart(self.position, self.target, "target", "SpotLight")

    @property
    def center(self) -> Array:
        return np.asarray(self.position)

    @property
    def axes(self) -> Array:
        return look_at(self.position, self.target)

    @property
    def emission(self) -> Vector:
        return self.intensity


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Parallel light travelling along `direction`, with `irradiance` (W/m²) on a surface that faces it."""

    direction: Vector
    irradiance: Vector

    kind: ClassVar[str] = "directional"

    def __post_init__(self) -> None:
        direction = vector(self.direction, "direction", "DirectionalLight")
        length = float(np.linalg.norm(direction))
        if not length > 0.0:
            raise SceneError(
                "DirectionalLight: direction must not be zero", code="LOOK_AT_DEGENERATE", pointer="direction"
            )
        x, y, z = direction
        _set(
            self,
            direction=(x / length, y / length, z / length),
            irradiance=_color(self.irradiance, "irradiance", "DirectionalLight"),
        )

    @property
    def center(self) -> Array:
        """The origin: a directional light has no place."""
        return np.zeros(3)

    @property
    def axes(self) -> Array:
        return look_at((0.0, 0.0, 0.0), self.direction)

    @property
    def emission(self) -> Vector:
        return self.irradiance


def facing(light: Light, position: npt.NDArray[np.floating], normal: npt.NDArray[np.floating]) -> npt.NDArray[np.bool_]:
    """True where the whole light lies in front of the receiver's plane, and the receiver in front of a one-sided light.

    `position` and geometric `normal` are (..., 3), world space; returns (...) bool. Elsewhere darkness is the shading's
    business, and the metrics leave those points out.
    """
    position, normal = np.asarray(position, np.float64), np.asarray(normal, np.float64)
    right, up, back = light.axes
    if light.kind == "directional":
        return normal @ back > 0.0
    to_center = light.center - position
    height = np.einsum("...i,...i->...", normal, to_center)  # of the light's centre above the receiver's plane
    a, b = light.half_extent
    slope_right, slope_up = a * (normal @ right), b * (normal @ up)
    drop = np.hypot(slope_right, slope_up) if light.kind == "disk" else np.abs(slope_right) + np.abs(slope_up)
    result = height > drop  # its lowest point is above too
    if light.one_sided:
        result &= to_center @ back > 0.0
    return result
