"""How near and how far a light's shadow maps must see."""

from __future__ import annotations

import numpy as np

from softshadows.scene.lights import Light


def reaches_into(boxes: np.ndarray, light: Light, margin: float) -> bool:
    """Can a point of the light lie within `margin` metres of one of the solids in `boxes` (k, 2, 3), or inside it?

    Then the light sees that solid from within, or its near planes cut it open.
    """
    if light.is_directional:
        return False
    reach = light.reach(np.eye(3)) + margin
    return bool(((boxes[:, 0] <= light.center + reach) & (boxes[:, 1] >= light.center - reach)).all(axis=1).any())


def depths(light: Light, bounds: np.ndarray, nearest: float) -> tuple[float, float]:
    """The distances between which the maps of a light see a box, metres; `nearest` where the light has a place."""
    if light.is_directional:
        return depth_range(bounds, -light.axes[2])
    return nearest, farthest(bounds, light.center)


def depth_range(bounds: np.ndarray, direction: np.ndarray) -> tuple[float, float]:
    """Nearest and farthest extent of a box along `direction`, with a margin."""
    low, high = np.sort(bounds * direction, axis=0).sum(axis=1)
    margin = max(1e-3 * (high - low), 1e-6)
    return float(low - margin), float(high + margin)


def farthest(bounds: np.ndarray, center: np.ndarray) -> float:
    """The distance from `center` that no point of a box exceeds."""
    return max(float(np.linalg.norm(np.abs(bounds - center).max(axis=0))), 1e-6)
