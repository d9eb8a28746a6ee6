"""Edges of a mesh and the triangles beside them, and its objects: triangles that are connected by common vertices.

For any triangles, closed or not. Counting all layers of surface between two points needs no closed surface: where the
line between them passes from one side of an edge to the other, the count changes by the edge's triangles on the one
side less those on the other (Bergeron 1986). So an edge here has one or two triangles, and one that more than two
share is as many edges of one triangle each; their changes add up.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from softshadows.scene.clusters import along_curve
from softshadows.scene.model import Mesh
from softshadows.scene.solids import connected_parts, over_corners, welded

Numbers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SLIVER = 1e-6
"""Height of a triangle over its longest side, below which it has no area."""
FLATNESS = 1e-5
"""By how much of its size a card may bend, and still be one."""


@dataclass(frozen=True, eq=False)
class MeshEdges:
    """Objects one after the other; within each, edges and triangles along a space-filling curve.

    vertices (e, 2) the edge's ends; triangles (e, 2) those beside it, −1 for none; is_forward (e, 2) where the triangle
    walks from the first end to the second; edge_starts (o + 1,); order (t,) the mesh's triangles, without those that
    have two corners at one place or are there twice, nor slivers that only open a seam; triangle_edges (t, 3) the edge
    from each corner of `order` to the next; triangle_starts (o + 1,); is_closed (o,) where no edge has an odd number of
    triangles; is_card (o,) where all triangles lie in one plane.
    """

    vertices: Numbers
    triangles: Numbers
    is_forward: Bools
    edge_starts: Numbers
    order: Numbers
    triangle_edges: Numbers
    triangle_starts: Numbers
    is_closed: Bools
    is_card: Bools


_known: WeakKeyDictionary[Mesh, tuple[int, MeshEdges]] = WeakKeyDictionary()
"""By mesh: a checksum of its arrays, which may be edited in place, and the answer."""


def edges_of(mesh: Mesh) -> MeshEdges:
    """The edges and objects of a mesh, its vertices at equal positions taken for one. Kept as long as the mesh."""
    checksum = zlib.crc32(mesh.triangles.tobytes(), zlib.crc32(mesh.positions.tobytes()))
    known = _known.get(mesh)
    if known is None or known[0] != checksum:
        known = _known[mesh] = (checksum, _find(mesh.positions, mesh.triangles.astype(np.int64)))
    return known[1]


def _find(positions: npt.NDArray[np.float32], triangles: Numbers) -> MeshEdges:
    place = welded(positions)
    vertex_at = np.zeros(int(place.max(initial=-1)) + 1, np.int64)
    vertex_at[place[::-1]] = np.arange(len(positions))[::-1]  # the first vertex at each place
    corners = place[triangles]
    a, b, c = corners.T
    kept = np.flatnonzero((a != b) & (b != c) & (c != a))
    halves = _half_edges(corners[kept])
    if (halves["sharing"] > 2).any():
        kept = kept[_first_of_equals(corners[kept])]
        halves = _half_edges(corners[kept])
    is_odd = halves["sharing"] % 2 == 1
    if is_odd.any():  # a triangle without area may close a seam, or open one
        with_area = kept[~_is_sliver(positions[triangles[kept]].astype(np.float64))]
        others = _half_edges(corners[with_area])
        if np.count_nonzero(others["sharing"] % 2 == 1) <= np.count_nonzero(is_odd):
            kept, halves = with_area, others
    corners = corners[kept]

    # Objects, numbered in the order of their first triangle.
    label = connected_parts(_neighbors(corners)) if len(corners) else np.zeros(0, np.int64)
    objects, object_of = np.unique(label, return_inverse=True)
    is_odd = np.bincount(object_of, (halves["sharing"] % 2 == 1).any(axis=1), len(objects)) > 0

    # Sort triangles and edges by object, and within it along a curve.
    order = _sorted(positions[vertex_at[corners]], object_of)
    first, second = halves["first"], halves["second"]
    start = corners.reshape(-1)
    ends = np.stack([start, np.roll(corners, -1, axis=1).reshape(-1)], axis=1)[first]
    edge_object = object_of[first // 3]
    edge_order = _sorted(positions[vertex_at[ends]], edge_object)
    place_of_edge = np.empty(len(edge_order), np.int64)
    place_of_edge[edge_order] = np.arange(len(edge_order))
    first, second, ends = first[edge_order], second[edge_order], ends[edge_order]
    ends = vertex_at[ends]
    beside = np.stack([first, second], axis=1)
    return MeshEdges(
        vertices=np.sort(ends, axis=1),
        triangles=np.where(beside < 0, -1, kept[beside // 3]) if len(kept) else beside,
        is_forward=vertex_at[start][beside] == ends.min(axis=1)[:, None] if len(kept) else np.zeros((0, 2), bool),
        edge_starts=_starts(edge_object[edge_order], len(objects)),
        order=kept[order],
        triangle_edges=place_of_edge[halves["edge"][order]],
        triangle_starts=_starts(object_of[order], len(objects)),
        is_closed=~is_odd,
        is_card=_flat_objects(positions[vertex_at[corners]].astype(np.float64), object_of, len(objects)),
    )


def _half_edges(corners: Numbers) -> Mapping[str, Numbers]:
    """How the sides of (t, 3) triangles meet: side 3 t + k runs from corner k of triangle t to the next.

    edge, sharing (t, 3): the edge of each side, how many sides lie there; first, second (e,): the sides of each edge,
    −1 for none.
    """
    count = int(corners.max(initial=0)) + 1
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    key = np.minimum(start, end) * count + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    is_new = np.ones(len(order), bool)
    is_new[1:] = np.diff(key[order]) != 0
    groups = np.flatnonzero(is_new)
    sizes = np.diff(np.append(groups, len(order)))
    sharing = np.repeat(sizes, sizes)

    heads = np.flatnonzero(is_new | (sharing != 2))  # two sides make one edge, any other number as many
    following = np.append(order[1:], -1)[heads]
    edge, sharing_of_side = np.empty((2, len(order)), np.int64)
    edge[order] = np.cumsum(is_new | (sharing != 2)) - 1
    sharing_of_side[order] = sharing
    return {
        "edge": edge.reshape(-1, 3),
        "sharing": sharing_of_side.reshape(-1, 3),
        "first": order[heads],
        "second": np.where(sharing[heads] == 2, following, -1),
    }


def _neighbors(corners: Numbers) -> Numbers:
    """(t, 3) for each corner of a triangle the next triangle around its vertex: in the end, all of them in a circle.

    Across T-junctions triangles share no edge, but a vertex.
    """
    order = np.argsort(corners.reshape(-1), kind="stable")
    vertex = corners.reshape(-1)[order]
    first = np.searchsorted(vertex, vertex)
    is_last = np.append(vertex[1:] != vertex[:-1], True)
    following = np.append(order[1:], 0)
    neighbors = np.empty(len(order), np.int64)
    neighbors[order] = np.where(is_last, order[first], following) // 3
    return neighbors.reshape(-1, 3)


def _first_of_equals(corners: Numbers) -> Numbers:
    """Triangles without repetitions of the same three corners, wound either way."""
    low, middle, high = np.sort(corners, axis=1).T
    pair = np.unique(low * (int(corners.max()) + 1) + middle, return_inverse=True)[1]
    return np.sort(np.unique(pair * (int(corners.max()) + 1) + high, return_index=True)[1])


def _is_sliver(corner: npt.NDArray[np.float64]) -> Bools:
    """(t,) of (t, 3, 3) corners: no area to speak of."""
    sides = corner - np.roll(corner, -1, axis=1)
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return twice_area <= SLIVER * (sides**2).sum(axis=2).max(axis=1)


def _sorted(corners: npt.NDArray[np.float32], object_of: Numbers) -> Numbers:
    """The order of triangles or edges, corners (n, k, 3), by object, and along a curve within each."""
    if not len(corners):
        return np.zeros(0, np.int64)
    order = along_curve(np.ascontiguousarray(over_corners(np.add, corners).T))
    return order[np.argsort(object_of[order], kind="stable")]


def _starts(object_of: Numbers, count: int) -> Numbers:
    """(count + 1,) where each object begins in a sorted list of owners."""
    return np.searchsorted(object_of, np.arange(count + 1))


def _flat_objects(corner: npt.NDArray[np.float64], object_of: Numbers, count: int) -> Bools:
    """(count,) where all of an object's triangles, corners (t, 3, 3), lie in the plane of its largest."""
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(normal, axis=1)
    largest = np.lexsort((area, object_of))[np.searchsorted(np.sort(object_of), np.arange(count), side="right") - 1]
    unit = normal[largest] / np.maximum(area[largest], 1e-300)[:, None]
    offset = corner - corner[largest, 0][object_of][:, None]
    height = over_corners(np.maximum, np.abs(np.einsum("tkc,tc->tk", offset, unit[object_of])))
    reach = over_corners(np.maximum, np.linalg.norm(offset, axis=2))
    bent, size = np.zeros(count), np.zeros(count)
    np.maximum.at(bent, object_of, height)
    np.maximum.at(size, object_of, reach)
    return bent <= FLATNESS * size
