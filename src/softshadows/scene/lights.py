"""The lights: rectangles, disks and lines that cast soft shadows, and the zero-size lights of glTF.

Every light has a local frame (rows right, up, back; it emits along −back), a centre and a half extent, and maps the
square [−1, 1]² onto its surface. A class says of its shape all that samplers, shadow maps, truth and metrics ask; what
its kind looks like to a shader is lights/<kind>.wgsl. `LIGHT_CLASSES` lists them.

Units: metres; `radiance` in W/(m² sr) for surfaces, W/(m sr) for lines (the radiant intensity of one metre seen from
the side); `intensity` in W/sr; `irradiance` in W/m². RGB, linear.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError
from softshadows.scene.vectors import Array, Vector, VectorLike, look_at, number, vector

MAX_RADIANCE = 1e9
MAX_EXTENT = 1e6


def _color(value: object, name: str, owner: str) -> Vector:
    color = vector(value, name, owner, limit=MAX_RADIANCE)
    if min(color) < 0.0:
        raise SceneError(
            f"{owner}: {name} must not be negative, got {value!r}", code="VALUE_NOT_IN_RANGE", pointer=name
        )
    return color


def _extent(value: object, name: str, owner: str) -> float:
    return number(value, name, owner, 0.0, MAX_EXTENT)


def _up(value: object, name: str, owner: str) -> Vector | None:
    return None if value is None else vector(value, name, owner)


CHECKS: Mapping[str, Callable[[object, str, str], object]] = {
    **dict.fromkeys(("position", "target", "start", "end", "direction"), vector),
    "up": _up,
    **dict.fromkeys(("radiance", "intensity", "irradiance"), _color),
    **dict.fromkeys(("width", "height", "radius"), _extent),
    "outer_angle": lambda value, name, owner: number(value, name, owner, 0.0, 90.0, open_low=True),
    "two_sided": lambda value, name, owner: bool(value),
}
"""How a light's field of that name is checked and made plain: a function of value, field and class, or SceneError."""


def _shifted(point: Vector, offset: VectorLike) -> Vector:
    x, y, z = np.add(point, offset).tolist()
    return (x, y, z)


@dataclass(frozen=True)
class Light:
    """What all lights share. Use one of the subclasses; their fields are checked by their names (`CHECKS`)."""

    kind: ClassVar[str] = ""
    is_directional: ClassVar[bool] = False
    """Its rays are parallel, and it has no place: `center` is the origin."""
    is_round: ClassVar[bool] = False
    """It fills the ellipse of its half extent, not the rectangle."""

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self)):
            if name in CHECKS:
                self._set(name, CHECKS[name](getattr(self, name), name, type(self).__name__))

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @property
    def center(self) -> Array:
        """(3,) float64, world space."""
        raise NotImplementedError

    @property
    def axes(self) -> Array:
        """Rows right, up, back: (3, 3) float64, world space; the light emits along −back."""
        raise NotImplementedError

    @property
    def emission(self) -> Vector:
        """Radiance, intensity or irradiance, after the light's kind."""
        raise NotImplementedError

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half width along right and half height along up, metres; (0, 0) for a light without size."""
        return (0.0, 0.0)

    @property
    def has_size(self) -> bool:
        return self.half_extent != (0.0, 0.0)

    @property
    def one_sided(self) -> bool:
        """True where the light emits only into the half space before it (a property of rectangles and disks)."""
        return False

    @property
    def is_flat(self) -> bool:
        """True where the light is a surface in one plane, such as a lamp's luminous face."""
        return False

    @property
    def cone(self) -> tuple[float, float]:
        """Degrees from −back: full emission within the first angle, none beyond the second."""
        return (0.0, 90.0)

    @property
    def without_size(self) -> Self:
        """The light shrunk to its centre, as one of the same kind."""
        return self

    def moved(self, offset: VectorLike) -> Self:
        """The light moved by `offset` (3,), metres; a directional one turns, as if it shone from one metre away."""
        places = {name: getattr(self, name) for name in ("position", "target", "start", "end") if hasattr(self, name)}
        return replace(self, **{name: _shifted(place, offset) for name, place in places.items()})

    def holds(self, points: Array) -> npt.NDArray[np.bool_]:
        """(...) bool: do points (..., 2) of light space, within the half extent, lie on the light?"""
        if not self.is_round:
            return np.ones(points.shape[:-1], bool)
        a, b = self.half_extent
        return np.hypot(points[..., 0] / a, points[..., 1] / b) <= 1.0

    def in_plane(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Metres along right and up of points (x, y) of the square [−1, 1]²; equal areas map to equal areas.

        Round lights take the concentric map of Shirley and Chiu (1997): squares become circles.
        """
        a, b = self.half_extent
        if not self.is_round:
            return a * x, b * y
        outer = np.where(np.abs(x) > np.abs(y), x, y)
        safe = np.where(outer == 0.0, 1.0, outer)
        angle = np.where(np.abs(x) > np.abs(y), (np.pi / 4.0) * y / safe, np.pi / 2.0 - (np.pi / 4.0) * x / safe)
        return a * outer * np.cos(angle), b * outer * np.sin(angle)

    def points(self, s: Array, t: Array) -> Array:
        """World positions, (..., 3) float64, of points (s, t) of the unit square, mapped as by `in_plane`."""
        s, t = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(t, np.float64))
        x, y = self.in_plane(2.0 * s - 1.0, 2.0 * t - 1.0)
        right, up, _ = self.axes
        return self.center + x[..., None] * right + y[..., None] * up

    def reach(self, direction: npt.NDArray[np.floating]) -> Array:
        """How far the light extends from its centre along unit vectors (..., 3), world space: (...) metres."""
        right, up, _ = self.axes
        a, b = self.half_extent
        along_right, along_up = a * (direction @ right), b * (direction @ up)
        return np.hypot(along_right, along_up) if self.is_round else np.abs(along_right) + np.abs(along_up)

    def facing(self, position: npt.NDArray[np.floating], normal: npt.NDArray[np.floating]) -> npt.NDArray[np.bool_]:
        """True where the whole light lies before the receiver's plane, and the receiver before a one-sided light.

        `position` and geometric `normal` are (..., 3), world space; returns (...) bool. Elsewhere darkness is the
        shading's business, and the metrics leave those points out.
        """
        position, normal = np.asarray(position, np.float64), np.asarray(normal, np.float64)
        to_center = self.center - position
        height = np.einsum("...i,...i->...", normal, to_center)  # of the light's centre above the receiver's plane
        result = height > self.reach(normal)  # its lowest point is above too
        if self.one_sided:
            result &= to_center @ self.axes[2] > 0.0
        return result


@dataclass(frozen=True)
class _Aimed(Light):
    """A light at `position` that emits towards `target`."""

    position: Vector
    target: Vector

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.position == self.target:
            owner = type(self).__name__
            raise SceneError(f"{owner}: position and target must differ", code="LOOK_AT_DEGENERATE", pointer="target")

    @property
    def center(self) -> Array:
        return np.asarray(self.position)

    @property
    def axes(self) -> Array:
        return look_at(self.position, self.target)


class _Face(_Aimed):
    """A flat luminous surface, of which one side emits, or both."""

    radiance: Vector
    two_sided: bool

    @property
    def one_sided(self) -> bool:
        return not self.two_sided

    @property
    def is_flat(self) -> bool:
        return min(self.half_extent) > 0.0

    @property
    def emission(self) -> Vector:
        return self.radiance


@dataclass(frozen=True)
class RectLight(_Face):
    """A rectangle centred at `position`, emitting towards `target`; width runs along its right, height along its up.

    A width or height of zero is legal and gives a zero-size light. Raises SceneError for values that are not finite,
    negative sizes or radiance, and position = target.
    """

    width: float
    height: float
    radiance: Vector
    two_sided: bool = False
    up: Vector | None = None

    kind: ClassVar[str] = "rect"

    @property
    def axes(self) -> Array:
        return look_at(self.position, self.target, self.up)

    @property
    def half_extent(self) -> tuple[float, float]:
        return (self.width / 2.0, self.height / 2.0)

    @property
    def without_size(self) -> Self:
        return replace(self, width=0.0, height=0.0)


@dataclass(frozen=True)
class DiskLight(_Face):
    """A disk of `radius` centred at `position`, emitting towards `target`. Errors as RectLight."""

    radius: float
    radiance: Vector
    two_sided: bool = False

    kind: ClassVar[str] = "disk"
    is_round: ClassVar[bool] = True

    @property
    def half_extent(self) -> tuple[float, float]:
        return (self.radius, self.radius)

    @property
    def without_size(self) -> Self:
        return replace(self, radius=0.0)


@dataclass(frozen=True)
class LineLight(Light):
    """A straight segment of zero radius from `start` to `end`, emitting all around. Errors as RectLight."""

    start: Vector
    end: Vector
    radiance: Vector

    kind: ClassVar[str] = "line"

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
    def without_size(self) -> Self:
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
class SpotLight(_Aimed):
    """A point light with a cone to `target`: full `intensity` (W/sr) within `inner_angle`, none beyond `outer_angle`.

    Angles in degrees from the axis, 0 ≤ inner < outer ≤ 90; between them the smooth fall-off of KHR_lights_punctual.
    """

    intensity: Vector
    inner_angle: float = 0.0
    outer_angle: float = 45.0

    kind: ClassVar[str] = "spot"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("inner_angle", number(self.inner_angle, "inner_angle", "SpotLight", 0.0, self.outer_angle))

    @property
    def emission(self) -> Vector:
        return self.intensity

    @property
    def cone(self) -> tuple[float, float]:
        return (self.inner_angle, self.outer_angle)


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Parallel light travelling along `direction`, with `irradiance` (W/m²) on a surface that faces it."""

    direction: Vector
    irradiance: Vector

    kind: ClassVar[str] = "directional"
    is_directional: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        length = float(np.linalg.norm(self.direction))
        if not length > 0.0:
            raise SceneError(
                "DirectionalLight: direction must not be zero", code="LOOK_AT_DEGENERATE", pointer="direction"
            )
        x, y, z = self.direction
        self._set("direction", (x / length, y / length, z / length))

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

    def moved(self, offset: VectorLike) -> Self:
        return replace(self, direction=_shifted(self.direction, np.negative(offset)))

    def facing(self, position: npt.NDArray[np.floating], normal: npt.NDArray[np.floating]) -> npt.NDArray[np.bool_]:
        return np.asarray(normal, np.float64) @ self.axes[2] > 0.0


LIGHT_CLASSES: Mapping[str, type[Light]] = {
    light.kind: light
    for light in (
        RectLight,
        DiskLight,
        LineLight,
        PointLight,
        SpotLight,
        DirectionalLight,
    )
}
"""By kind."""
