"""Boxes around clusters of triangles: a coarse picture of where occluders are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.scene.geometry import Geometry

MOST_CLUSTERS = 512
TRIANGLES_PER_CLUSTER = 64
_GRID = 1024  # cells along each axis of the space-filling curve


def cluster_boxes(geometry: Geometry, most: int = MOST_CLUSTERS) -> npt.NDArray[np.float32]:
    """(n, 2, 3) float32 low and high corners, world space, n ≤ `most`; together they hold every triangle.

    Every node has clusters of its own, so that a plane such as the ground keeps a flat box; a node's triangles are
    grouped along a Morton curve through their centres. With more nodes than `most`, neighbours in the scene's order
    share a box.
    """
    triangle_count = len(geometry.triangles)
    if triangle_count == 0:
        return np.zeros((0, 2, 3), np.float32)
    corners = geometry.positions[geometry.triangles]
    counts = np.diff(geometry.node_starts)
    per_cluster = max(TRIANGLES_PER_CLUSTER, triangle_count / max(most - len(counts), most // 2))
    order, starts = [], []
    for first, count in zip(geometry.node_starts[:-1], counts, strict=True):
        node = np.arange(first, first + count)
        pieces = max(int(count / per_cluster), 1)
        if pieces > 1:
            node = node[np.argsort(_morton(corners[node].mean(axis=1)), kind="stable")]
        order.append(node)
        starts.append(first + np.arange(pieces) * count // pieces)
    sorted_corners = corners[np.concatenate(order)]
    first = np.concatenate(starts)
    low = np.minimum.reduceat(sorted_corners.min(axis=1), first, axis=0)
    high = np.maximum.reduceat(sorted_corners.max(axis=1), first, axis=0)
    while len(low) > most:  # pair up neighbours
        pairs = np.arange(0, len(low), 2)
        low, high = np.minimum.reduceat(low, pairs, axis=0), np.maximum.reduceat(high, pairs, axis=0)
    return np.stack([low, high], axis=1)


def _morton(points: npt.NDArray[np.floating]) -> npt.NDArray[np.uint64]:
    """Codes that put (n, 3) points in the order of a Z-shaped space-filling curve."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / np.maximum(high - low, 1e-30) * (_GRID - 1)).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return code
