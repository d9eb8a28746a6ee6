"""The lattice of points on a light that adaptive sampling chooses from, and its levels.

A rectangle has (2^d + 1)² points for depth d, a line 2^d + 1, a light without size one. The lattice's coarsest level is
the light's corners; each further one halves the cells. A point's number is row × columns + column.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows.lights.jitter import moved
from softshadows.scene.lights import Light

DEEPEST = 4
"""289 points of a rectangle. A row of points is a word of 32 bits to the shaders, which 33 would exceed."""

_GOLDEN = 0.61803398874989484820
"""Steps by the golden ratio fill an interval evenly, however many they are."""


@dataclass(frozen=True)
class Lattice:
    """`depth` halvings along each of the light's extents that are not zero."""

    depth: int
    has_columns: bool
    has_rows: bool

    @property
    def columns(self) -> int:
        return (1 << self.depth) + 1 if self.has_columns else 1

    @property
    def rows(self) -> int:
        return (1 << self.depth) + 1 if self.has_rows else 1

    @property
    def samples(self) -> int:
        """Points in all."""
        return self.rows * self.columns

    @property
    def dimensions(self) -> int:
        return self.has_columns + self.has_rows

    def spacing(self, level: int) -> int:
        """Deepest lattice steps along the side of a level's cell."""
        return 1 << (self.depth - level)

    def count(self, level: int) -> int:
        """Points that appear first at `level`."""
        side = (1 << level) + 1
        coarser = (1 << (level - 1)) + 1 if level else 0
        return side**self.dimensions - (coarser**self.dimensions if level else 0)

    def points(
        self, light: Light, shift: tuple[float, float] = (0.0, 0.0), *, is_sheared: bool = False
    ) -> npt.NDArray[np.float64]:
        """(rows × columns, 2): the points in light space, metres, moved by `shift` steps of the lattice.

        Sheared, no two points of a rectangle share an x or a y: an edge along a side of the light then crosses them one
        by one, not a row at a time (Kensler, "Correlated multi-jittered sampling", 2013).
        """
        across, up = light.half_extent
        extents = (across, up) if self.has_rows else (max(across, up), 0.0)
        row, column = np.mgrid[: self.rows, : self.columns]
        shear = 1.0 if is_sheared and self.has_rows else 0.0
        x = _places(column, self.columns, shift[0] + shear * _share(row, self.rows)) * extents[0]
        y = _places(row, self.rows, shift[1] + shear * _share(column, self.columns)) * extents[1]
        points = np.stack([x.ravel(), y.ravel()], axis=1)
        return points if across > 0.0 or self.dimensions == 0 else points[:, ::-1]


def lattice_of(light: Light, depth: int) -> Lattice:
    """The lattice for a light's shape: by how many of its extents are not zero."""
    dimensions = sum(extent > 0.0 for extent in light.half_extent)
    return Lattice(depth if dimensions else 0, dimensions > 0, dimensions == 2)


def _places(step: np.ndarray, count: int, by: np.ndarray | float) -> npt.NDArray[np.float64]:
    """Where the steps 0 … count − 1 lie in [−1, 1], moved `by` a share of their spacing."""
    spacing = 2.0 / max(count - 1, 1)
    return moved(step * spacing - 1.0, spacing, by) if count > 1 else np.zeros(step.shape)


def _share(step: np.ndarray, count: int) -> npt.NDArray[np.float64]:
    """In [−½, ½], evenly filled by any stretch of steps and by every second or fourth one; odd about the middle."""
    return np.remainder(_GOLDEN * (step - (count - 1) / 2.0) + 0.5, 1.0) - 0.5
