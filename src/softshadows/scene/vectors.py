"""Checked three-vectors and the one look-at that cameras and lights share: right-handed, y up, forward = −z."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError

Vector = tuple[float, float, float]
VectorLike = Sequence[float] | npt.NDArray[np.floating]
Array = npt.NDArray[np.float64]

LIMIT = 1e12
"""Largest coordinate in metres: beyond it a product of two float32 differences can overflow."""


def vector(value: object, name: str, owner: str, *, limit: float = LIMIT) -> Vector:
    """`value` as three finite floats, or a SceneError that names `owner` and `name`."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,):
        raise SceneError(
            f"{owner}: {name} must be three numbers, got {value!r}", code="VALUE_NOT_VECTOR3", pointer=name
        )
    if not np.isfinite(array).all() or np.abs(array).max() > limit:
        raise SceneError(
            f"{owner}: {name} must be finite and at most {limit:g} in size, got {value!r}",
            code="VALUE_NOT_FINITE",
            pointer=name,
        )
    return (float(array[0]), float(array[1]), float(array[2]))


def number(value: object, name: str, owner: str, low: float, high: float, *, open_low: bool = False) -> float:
    """`value` as a float in [low, high] (or (low, high]), or a SceneError that names `owner` and `name`."""
    interval = f"{'(' if open_low else '['}{low:g}, {high:g}]"
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise SceneError(
            f"{owner}: {name} must be a number in {interval}, got {value!r}", code="VALUE_NOT_NUMBER", pointer=name
        )
    result = float(value)
    if not low <= result <= high or (open_low and result == low):  # also refuses NaN
        raise SceneError(
            f"{owner}: {name} must lie in {interval}, got {value!r}", code="VALUE_NOT_IN_RANGE", pointer=name
        )
    return result


def look_at(position: VectorLike, target: VectorLike, up: VectorLike | None = None) -> Array:
    """Rows right, up', back of the frame at `position` that looks at `target` along its −z: (3, 3) float64.

    right = forward × up, up' = right × forward; `up` defaults to +y, and is −z where forward is parallel to it.
    """
    forward = np.asarray(target, np.float64) - np.asarray(position, np.float64)
    length = np.linalg.norm(forward)
    if not length > 0.0:
        raise SceneError("position and target must differ", code="LOOK_AT_DEGENERATE", pointer="target")
    forward = forward / length
    right = np.cross(forward, np.asarray((0.0, 1.0, 0.0) if up is None else up, np.float64))
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(forward, (0.0, 0.0, -1.0))
        if np.linalg.norm(right) < 1e-9:  # an explicit `up` along z
            right = np.cross(forward, (0.0, 1.0, 0.0))
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), -forward])
