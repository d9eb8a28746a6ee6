"""Which meshes are solid: closed and wound outward, so that from outside the first triangle met faces the viewer.

A shadow map of a solid needs only the triangles that face the light (`visibility/maps`).
"""

from __future__ import annotations

import functools
import zlib
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from softshadows.scene.model import Mesh

Numbers = npt.NDArray[np.int64]

_found: WeakKeyDictionary[Mesh, tuple[int, bool]] = WeakKeyDictionary()
"""By mesh: a checksum of its arrays, which may be edited in place, and the answer."""


def is_solid(mesh: Mesh) -> bool:
    """True where the mesh is opaque and all its parts are closed, consistently wound and enclose a positive volume.

    Parts are triangles connected across edges, vertices at equal positions taken for one. Closed means that every
    directed edge occurs exactly once, and its reverse exactly once; triangles with two corners at one place are left
    out. The answer is kept as long as the mesh.
    """
    if mesh.material.alpha_cutoff is not None:
        return False
    checksum = zlib.crc32(mesh.triangles.tobytes(), zlib.crc32(mesh.positions.tobytes()))
    known = _found.get(mesh)
    if known is None or known[0] != checksum:
        known = _found[mesh] = (checksum, _encloses(mesh.positions, mesh.triangles))
    return known[1]


def _encloses(positions: npt.NDArray[np.float32], triangles: npt.NDArray[np.uint32]) -> bool:
    """`is_solid` of (n, 3) positions and (t, 3) triangles."""
    corners = welded(positions)[triangles.astype(np.intp)]
    a, b, c = corners.T
    whole = (a != b) & (b != c) & (c != a)
    neighbors = _neighbors(corners[whole])
    if neighbors is None or not len(neighbors):
        return False
    part = connected_parts(neighbors)
    # Volumes from tetrahedra over each part's first corner: parts far from the origin lose no digits.
    corner = positions[triangles[whole].astype(np.intp)].astype(np.float64)
    u, v, w = (corner - corner[part, :1]).transpose(1, 2, 0)
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = u, v, w
    six_volumes = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
    volumes = np.bincount(part, six_volumes, len(part))
    return bool((volumes[np.unique(part)] > 0.0).all())


def welded(positions: npt.NDArray[np.float32]) -> Numbers:
    """(n,) a number for each of (n, 3) positions, the same for equal ones, from 0 on."""
    x, y, z = (positions.T + np.float32(0.0)).view(np.uint32).astype(np.uint64)  # -0 becomes 0
    in_plane = np.unique(x << np.uint64(32) | y, return_inverse=True)[1].astype(np.uint64)
    return np.unique(in_plane << np.uint64(32) | z, return_inverse=True)[1].astype(np.int64)


def _neighbors(corners: Numbers) -> Numbers | None:
    """(t, 3) the triangle across each edge of (t, 3) welded corners; None where an edge has not exactly one partner."""
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    count = int(corners.max(initial=0)) + 1
    forward, backward = start * count + end, end * count + start
    order, partner = np.argsort(forward), np.argsort(backward)
    edges = forward[order]
    if (edges[1:] == edges[:-1]).any() or not np.array_equal(edges, backward[partner]):
        return None
    neighbors = np.empty(len(start), np.int64)
    neighbors[order] = partner // 3
    return neighbors.reshape(-1, 3)


def over_corners(function: np.ufunc, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """`function` over the second of an array's axes, (n, k, ...): faster than its `reduce` where k is 2 or 3."""
    return functools.reduce(function, np.moveaxis(values, 1, 0))


def connected_parts(neighbors: Numbers) -> Numbers:
    """(t,) the lowest triangle that each triangle is connected to, from the (t, 3) triangles across their edges.

    Labels are hooked to lower ones and paths shortened until nothing changes (Zhang, Azad, Hu 2020, "FastSV").
    """
    label = np.arange(len(neighbors))
    while True:
        grandparent = label[label]
        lowest = np.minimum(over_corners(np.minimum, grandparent[neighbors]), grandparent)
        hooked = label.copy()
        np.minimum.at(hooked, label, lowest)
        hooked = np.minimum(hooked, lowest)
        if np.array_equal(hooked, label):
            return label
        label = hooked
