"""A triangular light, and its three sides in its place, as Heidrich, Brabec and Seidel (2000, §4) shadow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows import metrics, truth
from softshadows.bench.suites.adaptive import facing_surfaces
from softshadows.compare.measure import ReferenceFrame
from softshadows.scene.lights import Light, LineLight
from softshadows.scene.model import Scene
from softshadows.scene.shot import Shot
from softshadows.scene.vectors import Vector

Floats = npt.NDArray[np.float32]

POINTS = 512
"""On the triangle, for its truth: the same for all pixels."""
R2_STEPS = (0.7548776662466927, 0.5698402909980532)
"""Roberts's sequence of low discrepancy: the reciprocals of 1.3247… and of its square."""


@dataclass(frozen=True)
class Triangle:
    """A light with corners in world space, metres, that shines with `radiance` W/(m² sr)."""

    corners: tuple[Vector, Vector, Vector]
    radiance: Vector

    @classmethod
    def within(cls, light: Light) -> Triangle:
        """The isosceles triangle as wide and as high as the light, and as bright."""
        left, right, top = light.points(np.array([0.0, 1.0, 0.5]), np.array([0.0, 0.0, 1.0])).tolist()
        return cls((tuple(left), tuple(right), tuple(top)), light.emission)

    @property
    def sides(self) -> list[LineLight]:
        """The lights that stand in for it."""
        return LineLight.outline(self.corners, self.radiance)

    def lit_by_sides(self, scene: Scene, name: str, size: tuple[int, int]) -> Shot:
        """The scene with the sides as its lights."""
        assert scene.camera is not None, "built-in scenes have one"
        scene.lights = list(self.sides)
        return Shot(name, scene, scene.camera, size)

    def truth(self, shot: Shot, base: ReferenceFrame) -> Floats:
        """(height, width): the share of the triangle that each pixel sees."""
        s, t = np.modf(0.5 + np.outer(R2_STEPS, np.arange(POINTS)))[0]
        is_beyond = s + t > 1.0
        s, t = np.where(is_beyond, 1.0 - s, s), np.where(is_beyond, 1.0 - t, t)
        corner, right, top = np.array(self.corners)
        points = corner + s[:, None] * (right - corner) + t[:, None] * (top - corner)
        return truth.visibility_from_points(shot.scene, facing_surfaces(base), points).mean(axis=0, dtype=np.float32)

    def rmse(self, visibility: Floats, own: Floats, base: ReferenceFrame) -> float:
        """From the mean of the sides' visibility (3, h, w), by their lengths, to its `own`, where all sides may see."""
        lengths = [side.half_extent[0] for side in self.sides]
        mean = np.average(visibility, axis=0, weights=lengths).astype(np.float32)
        return metrics.compare(mean, own, mask=np.logical_and.reduce(base.reference.mask)).rmse
