"""A perspective camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.vectors import Array, Vector, look_at, number, vector


@dataclass(frozen=True)
class Camera:
    """A pinhole camera looking from `position` at `target` (metres, world space).

    `vertical_fov` is the full vertical opening angle in degrees. `up` is +y, or −z where the camera looks along y.
    Raises SceneError for values that are not finite, an angle outside (0, 179], or position = target.
    """

    position: Vector
    target: Vector
    vertical_fov: float = 45.0
    up: Vector | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", vector(self.position, "position", "Camera"))
        object.__setattr__(self, "target", vector(self.target, "target", "Camera"))
        object.__setattr__(
            self, "vertical_fov", number(self.vertical_fov, "vertical_fov", "Camera", 0.0, 179.0, open_low=True)
        )
        if self.up is not None:
            object.__setattr__(self, "up", vector(self.up, "up", "Camera"))
        if self.position == self.target:
            raise SceneError("Camera: position and target must differ", code="LOOK_AT_DEGENERATE", pointer="target")

    @property
    def axes(self) -> Array:
        """Rows right, up, back: (3, 3) float64, world space. The camera looks along −back."""
        return look_at(self.position, self.target, self.up)

    def pixel_extent(self, height: int) -> float:
        """Height of one pixel on the plane one metre in front of the camera, for an image of `height` rows."""
        return 2.0 * float(np.tan(np.radians(self.vertical_fov) / 2.0)) / height
