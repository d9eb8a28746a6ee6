"""Boxes around clusters of triangles: a coarse picture of where occluders are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.scene.geometry import Geometry

MOST_CLUSTERS = 512
TRIANGLES_PER_CLUSTER = 64
_GRID = 1024  # cells along each axis of the space-filling curve
_SPREAD = ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249))
_CHUNK = 1 << 15  # triangles worked on at one time, so that the numbers stay in the processor's cache

Floats = npt.NDArray[np.float32]


def cluster_boxes(geometry: Geometry, most: int = MOST_CLUSTERS) -> npt.NDArray[np.float32]:
    """(n, 2, 3) float32 low and high corners, world space, n ≤ `most`; together they hold every triangle.

    Every node has clusters of its own, so that a plane such as the ground keeps a flat box; a node's triangles are
    grouped along a Morton curve through their centres. With more nodes than `most`, neighbours in the scene's order
    share a box.
    """
    triangle_count = len(geometry.triangles)
    if triangle_count == 0:
        return np.zeros((0, 2, 3), np.float32)
    low, high, middle = triangle_boxes(geometry)
    counts = np.diff(geometry.node_starts)
    per_cluster = max(TRIANGLES_PER_CLUSTER, triangle_count / max(most - len(counts), most // 2))
    order, starts = np.arange(triangle_count), []
    for begin, count in zip(geometry.node_starts[:-1], counts, strict=True):
        pieces = max(int(count / per_cluster), 1)
        if pieces > 1:
            order[begin : begin + count] = begin + along_curve(middle[:, begin : begin + count])
        starts.append(begin + np.arange(pieces) * count // pieces)
    first = np.concatenate(starts)
    low = np.stack([np.minimum.reduceat(axis.take(order), first) for axis in low], axis=1)
    high = np.stack([np.maximum.reduceat(axis.take(order), first) for axis in high], axis=1)
    while len(low) > most:  # pair up neighbours
        pairs = np.arange(0, len(low), 2)
        low, high = np.minimum.reduceat(low, pairs, axis=0), np.maximum.reduceat(high, pairs, axis=0)
    return np.stack([low, high], axis=1)


def triangle_boxes(geometry: Geometry) -> tuple[Floats, Floats, Floats]:
    """Low corners, high corners and centres of all triangles, (3, t) float32 each: rows x, y, z."""
    low, high, middle = (np.empty((3, len(geometry.triangles)), np.float32) for _ in range(3))
    for start in range(0, len(geometry.triangles), _CHUNK):
        part = slice(start, start + _CHUNK)
        corners = geometry.positions.take(geometry.triangles[part].astype(np.intp), axis=0)
        a, b, c = np.ascontiguousarray(corners.transpose(1, 2, 0))
        low[:, part] = np.minimum(np.minimum(a, b), c)
        high[:, part] = np.maximum(np.maximum(a, b), c)
        middle[:, part] = (a + b + c) / np.float32(3.0)
    return low, high, middle


def along_curve(points: Floats) -> npt.NDArray[np.intp]:
    """The order of (3, n) points along a Z-shaped space-filling curve; equals stay in their order."""
    low, high = points.min(axis=1, keepdims=True), points.max(axis=1, keepdims=True)
    cells = ((points - low) / np.maximum(high - low, np.float32(1e-30)) * np.float32(_GRID - 1)).astype(np.uint64)
    for shift, mask in _SPREAD:  # two empty bits after each bit
        cells = (cells | cells << np.uint64(shift)) & np.uint64(mask)
    x, y, z = cells
    code = x | y << np.uint64(1) | z << np.uint64(2)
    # Sorting codes with their places in the low bits is several times faster than a stable argsort.
    places = np.arange(points.shape[1], dtype=np.uint64)
    return (np.sort(code << np.uint64(32) | places) & np.uint64(0xFFFFFFFF)).astype(np.intp)
