"""A second opinion on Embree: every triangle against every ray, in float64, with nothing in common but the question.

Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): each ray becomes the z axis, vertices are
sheared into its plane, and 2-D edge functions decide. The edge function of a shared edge is the same two products with
the other sign, so that no ray slips between two triangles.
"""

from __future__ import annotations

import numpy as np

CHUNK = 64  # rays at a time: a few hundred triangles then stay in the cache, five times faster than 4096


def blocked(positions: np.ndarray, triangles: np.ndarray, start: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """(n,) bool: whether a triangle lies on start + t · ray with 0 < t ≤ 1; start, ray (n, 3) float."""
    return closest_edge(positions, triangles, start, ray)[0]


def closest_edge(
    positions: np.ndarray, triangles: np.ndarray, start: np.ndarray, ray: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`blocked`, and (n,) float64: how close each ray's line comes to the border of a triangle that its segment spans.

    The distance is the least barycentric coordinate, in absolute value, over triangles it crosses or nearly crosses.
    """
    chunks = [
        _cast(positions.astype(np.float64), triangles, start[rows].astype(np.float64), ray[rows].astype(np.float64))
        for rows in (slice(first, first + CHUNK) for first in range(0, len(start), CHUNK))
    ]
    return np.concatenate([hit for hit, _ in chunks]), np.concatenate([distance for _, distance in chunks])


def _cast(positions: np.ndarray, triangles: np.ndarray, start: np.ndarray, ray: np.ndarray):
    x, y, z = _sheared(positions, start, ray)
    a, b, c = triangles.T
    u = x[:, c] * y[:, b] - y[:, c] * x[:, b]
    v = x[:, a] * y[:, c] - y[:, a] * x[:, c]
    w = x[:, b] * y[:, a] - y[:, b] * x[:, a]
    inside = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0))
    total = u + v + w
    scale = np.where(total == 0.0, 1.0, total)
    t = (u * z[:, a] + v * z[:, b] + w * z[:, c]) / scale
    between = (total != 0.0) & (t > 0.0) & (t <= 1.0)
    least = np.minimum(np.minimum(u / scale, v / scale), w / scale)  # negative outside
    distance = np.where(between, np.abs(least), np.inf).min(axis=1, initial=np.inf)
    return (inside & between).any(axis=1), distance


def _sheared(positions: np.ndarray, start: np.ndarray, ray: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices in each ray's own axes, (n, vertices) each: x = y = 0 is the ray, and z its parameter t."""
    longest = np.abs(ray).argmax(axis=1)
    rows = np.arange(len(ray))
    first, second = (longest + 1) % 3, (longest + 2) % 3
    along = positions[:, longest].T - start[rows, longest][:, None]
    x = positions[:, first].T - start[rows, first][:, None] - (ray[rows, first] / ray[rows, longest])[:, None] * along
    y = (
        positions[:, second].T
        - start[rows, second][:, None]
        - (ray[rows, second] / ray[rows, longest])[:, None] * along
    )
    return x, y, along / ray[rows, longest][:, None]
