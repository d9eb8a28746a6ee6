"""Points of a grid on a light."""

from __future__ import annotations

import numpy as np

from softshadows.lights.jitter import moved
from softshadows.lights.sample_sets import Samples
from softshadows.scene.lights import Light

WEIGHTS = ("trapezoid", "equal", "midpoint")


def grid_samples(light: Light, grid: int, weights: str, shift: tuple[float, float] = (0.0, 0.0)) -> Samples:
    """Points (n, 2) of a grid on the light in light space, and their weights (n,), small whole numbers.

    The outer points lie on the light's border, and with `weights` trapezoid count half, in the corners a quarter;
    midpoint puts points into the middle of grid×grid cells. A line has `grid` points; a light without size, one. They
    are moved by `shift` steps of the grid.
    """
    a, b = light.half_extent
    if weights != "midpoint" and grid > 1:
        steps = np.linspace(-1.0, 1.0, grid)
        ramp = np.ones(grid)
        if weights == "trapezoid":
            ramp[1:-1] = 2.0
    else:
        steps = (2.0 * np.arange(grid) + 1.0) / grid - 1.0
        ramp = np.ones(grid)
    if a == 0.0 and b == 0.0:
        return np.zeros((1, 2)), np.ones(1)
    spacing = float(steps[1] - steps[0]) if grid > 1 else 2.0
    x, y = (moved(steps, spacing, by) for by in shift)
    if b == 0.0 or a == 0.0:
        line = np.stack([x * a, x * b], axis=1)
        return line, ramp
    points = light.in_plane(*np.meshgrid(x, y))
    return np.stack([axis.ravel() for axis in points], axis=1), np.outer(ramp, ramp).ravel()
