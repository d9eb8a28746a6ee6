"""What the CPU's tree is made of: a part over the nodes at rest, and one for each node that has moved.

A tree that is only refitted grows slow when things move far, since its boxes stretch over the way between. So a node
that moves for the first time leaves the part at rest, which stays as it is while the same nodes move:

    root
    |- at rest
    `- top level        by surface area over the boxes of what has moved; chosen anew with each move
       |- a node
       `- ...

Parts are filtered out of the tree that was built in the beginning, so that no move waits for a build. Positions are
world space and all parts lie in one array, so that walk and refit know nothing of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from softshadows.passes.bvh.sah import Floats, shape_by_area
from softshadows.passes.bvh.shape import Integers, Records, Shape, joined, ranges, records_of, starts_of
from softshadows.scene.clusters import triangle_boxes
from softshadows.scene.geometry import Geometry
from softshadows.scene.model import Mesh

Bools = npt.NDArray[np.bool_]


@dataclass(eq=False)
class Change:
    """What to write before the next refit: pieces of the order and of the shape's records, each with where it begins.
    And how many nodes there are then."""

    node_count: int
    order: list[tuple[int, Integers]] = field(default_factory=list)
    records: list[tuple[int, Records]] = field(default_factory=list)


class Parts:
    """The parts of one scene, from its first geometry on."""

    def __init__(self, geometry: Geometry) -> None:
        self._moves = Moves(geometry)
        self._whole = self._at_rest = shape_by_area(*triangle_boxes(geometry)[:2])
        self._of_nodes: list[Shape] = []
        self._is_new = True

    def follow(self, geometry: Geometry) -> Change:
        """What `geometry` changes, in which nodes may lie elsewhere than in the one before."""
        divides = self._moves.follow(geometry)
        if divides:
            self._divide()
        rest, moved = self._at_rest, self._joined()
        root = int(len(rest.order) > 0 and len(moved.order) > 0)
        first_place, first_node = len(rest.order), root + len(rest.first)
        change = Change(first_node + len(moved.first))
        if divides or self._is_new:
            if root:
                change.records.append((0, records_of(0, first_place + len(moved.order), change.node_count)))
            self._put(change, rest, 0, root)
        self._put(change, moved, first_place, first_node)
        self._is_new = False
        return change

    def _put(self, change: Change, part: Shape, first_place: int, first_node: int) -> None:
        if len(part.order):
            change.order.append((first_place, self._moves.listed(part.order)))
            change.records.append((first_node, part.records(first_place, first_node)))

    def _divide(self) -> None:
        """Let each node that has moved have its own tree."""
        moves, whole = self._moves, self._whole
        has_moved = moves.has_moved[moves.node_of[whole.order]]
        self._at_rest = whole.only(~has_moved)
        nodes = np.flatnonzero(moves.has_moved)
        self._of_nodes = _separated(whole.only(has_moved), moves.node_of, nodes) if len(nodes) else []

    def _joined(self) -> Shape:
        """The tree over all that has moved; empty if nothing has."""
        nodes = np.flatnonzero(self._moves.has_moved)
        if not len(nodes):
            return self._whole.only(np.zeros(len(self._whole.order), bool))
        return joined(shape_by_area(*self._moves.boxes(nodes), largest_leaf=1), self._of_nodes)


class Moves:
    """Which nodes of a scene have moved since its first geometry.

    Nodes, and their triangles, are numbered as there. Later geometries may list them in another order, since nodes that
    a transform flattens are not solid; which of several nodes with one mesh is which does not matter.
    """

    def __init__(self, geometry: Geometry) -> None:
        self._first = self._last = geometry
        counts = np.diff(geometry.node_starts)
        self.node_of = np.repeat(np.arange(len(counts)), counts)
        self.has_moved: Bools = np.zeros(len(counts), bool)
        self._listed_at = np.arange(len(counts))

    def follow(self, geometry: Geometry) -> bool:
        """Compare with the last geometry. Has another node moved, or is the order another one?"""
        listed_at = _listed_at(self._first.meshes, geometry.meshes)
        has_moved = self.has_moved | self._differs(geometry, listed_at)
        is_same = np.array_equal(has_moved, self.has_moved) and np.array_equal(listed_at, self._listed_at)
        self._last, self.has_moved, self._listed_at = geometry, has_moved, listed_at
        return not is_same

    def listed(self, triangles: Integers) -> Integers:
        """The triangles' numbers in the last geometry."""
        shift = self._last.node_starts[self._listed_at] - self._first.node_starts[:-1]
        return triangles + shift[self.node_of[triangles]]

    def boxes(self, nodes: Integers) -> tuple[Floats, Floats]:
        """Low and high corners of nodes in the last geometry, (3, n) float32 each."""
        starts, counts = _vertices(self._last, self._listed_at[nodes])
        corners = self._last.positions[ranges(starts, counts)].T.copy()
        at = starts_of(counts)[:-1]
        return np.minimum.reduceat(corners, at, axis=1), np.maximum.reduceat(corners, at, axis=1)

    def _differs(self, geometry: Geometry, listed_at: Integers) -> Bools:
        """(n,) by node: does it lie elsewhere than in the last geometry?"""
        if geometry is self._last:
            return np.zeros(len(listed_at), bool)
        before, counts = _vertices(self._last, self._listed_at)
        after, _ = _vertices(geometry, listed_at)
        differ = self._last.positions[ranges(before, counts)] != geometry.positions[ranges(after, counts)]
        return np.logical_or.reduceat(differ.any(axis=1), starts_of(counts)[:-1])


def _separated(shape: Shape, node_of: Integers, nodes: Integers) -> list[Shape]:
    """A tree for each of `nodes`, in their order, out of one over all of them: halved again and again, which takes time
    in proportion to triangles and the logarithm of the nodes' number."""
    if len(nodes) == 1:
        return [shape]
    half = len(nodes) // 2
    is_later = node_of[shape.order] >= nodes[half]
    earlier = _separated(shape.only(~is_later), node_of, nodes[:half])
    return [*earlier, *_separated(shape.only(is_later), node_of, nodes[half:])]


def _listed_at(first: Sequence[Mesh], later: Sequence[Mesh]) -> Integers:
    """By node of the first list: its place in the later one, which holds the same meshes."""
    orders = [np.argsort([id(mesh) for mesh in meshes], kind="stable") for meshes in (first, later)]
    result = np.empty(len(first), np.int64)
    result[orders[0]] = orders[1]
    return result


def _vertices(geometry: Geometry, listed_at: Integers) -> tuple[Integers, Integers]:
    """Where the vertices of nodes begin, and their numbers."""
    counts = np.array([len(mesh.positions) for mesh in geometry.meshes], np.int64)
    return starts_of(counts)[listed_at], counts[listed_at]
