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

from softshadows.scene.clusters import triangle_boxes
from softshadows.scene.geometry import Geometry
from softshadows.scene.model import Mesh
from softshadows.visibility.rays.sah import Floats, shape_by_area
from softshadows.visibility.rays.shape import Integers, Records, Shape, joined, ranges, records_of, starts_of

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
        self._whole = shape_by_area(*triangle_boxes(geometry)[:2])
        self._at_rest = self._whole
        self._of_nodes: list[Shape] = []
        self._top = Shape.empty()
        self._node_count = 0

    def follow(self, geometry: Geometry) -> Change:
        """What `geometry` changes, in which nodes may lie elsewhere than in the one before."""
        divides = self._moves.follow(geometry) or not self._node_count
        if divides:
            self._divide()
        nodes = np.flatnonzero(self._moves.has_moved)
        top = shape_by_area(*self._moves.boxes(nodes), largest_leaf=1) if len(nodes) else Shape.empty()
        is_same = np.array_equal(top.order, self._top.order) and np.array_equal(top.skip, self._top.skip)
        if is_same and not divides:
            return Change(self._node_count)
        self._top = top
        return self._laid_out(divides)

    def _divide(self) -> None:
        """Let each node that has moved have its own tree."""
        moves, whole = self._moves, self._whole
        has_moved = moves.has_moved[moves.node_of[whole.order]]
        self._at_rest = whole.only(~has_moved)
        nodes = np.flatnonzero(moves.has_moved)
        self._of_nodes = _separated(whole.only(has_moved), moves.node_of, nodes) if len(nodes) else []

    def _laid_out(self, divides: bool) -> Change:
        """All parts, or those that have moved, in their places."""
        rest, moved = self._at_rest, joined(self._top, self._of_nodes) if self._of_nodes else Shape.empty()
        root = int(len(rest.order) > 0 and len(moved.order) > 0)
        first_place, first_node = len(rest.order), root + len(rest.first)
        change = Change(first_node + len(moved.first))
        if divides and root:
            change.records.append((0, records_of(0, first_place + len(moved.order), change.node_count)))
        for part, place, node in ((rest, 0, root), (moved, first_place, first_node))[0 if divides else 1 :]:
            if len(part.order):
                change.order.append((place, self._moves.listed(part.order)))
                change.records.append((node, part.records(place, node)))
        self._node_count = change.node_count
        return change


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
        positions, counts = _positions(self._last, self._listed_at[nodes])
        corners, at = positions.T.copy(), starts_of(counts)[:-1]
        return np.minimum.reduceat(corners, at, axis=1), np.maximum.reduceat(corners, at, axis=1)

    def _differs(self, geometry: Geometry, listed_at: Integers) -> Bools:
        """(n,) by node: does it lie elsewhere than in the last geometry?"""
        if geometry is self._last:
            return np.zeros(len(listed_at), bool)
        before, counts = _positions(self._last, self._listed_at)
        after, _ = _positions(geometry, listed_at)
        return np.logical_or.reduceat((before != after).any(axis=1), starts_of(counts)[:-1])


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


def _positions(geometry: Geometry, listed_at: Integers) -> tuple[Floats, Integers]:
    """The positions of nodes, one after the other, and each node's number of them."""
    counts = np.array([len(mesh.positions) for mesh in geometry.meshes], np.int64)
    if np.array_equal(listed_at, np.arange(len(counts))):
        return geometry.positions, counts
    return geometry.positions[ranges(starts_of(counts)[listed_at], counts[listed_at])], counts[listed_at]
