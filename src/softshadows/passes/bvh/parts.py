"""What the scene's tree is made of: a part over the nodes at rest, and a part over those that have moved.

A tree that is only refitted grows slow when things move far, since its boxes stretch over the way between. So a node
that moves for the first time leaves the part at rest, which stays as it is while the same nodes move:

    root
    |- at rest
    `- moved        by the CPU: a tree for each node, under a top level that each move chooses by surface area
                    by the GPU: one tree, which each move builds again

The CPU's trees are filtered out of the one that it built in the beginning, so that no node's first move waits for a
build. Positions are world space and all nodes lie in one array, so that walk and refit know nothing of parts.
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

LBVH_LEAF = 4
"""Triangles in a leaf of a tree that the GPU builds (lbvh.wgsl)."""


@dataclass(frozen=True)
class Build:
    """A tree for the GPU to build: over `count` triangles listed from `first_place` on, into nodes from `first_node`
    on."""

    first_place: int
    count: int
    first_node: int


@dataclass(eq=False)
class Change:
    """What to write before the next refit, each piece with where it begins, and then to build; the tree's nodes."""

    node_count: int
    order: list[tuple[int, Integers]] = field(default_factory=list)
    records: list[tuple[int, Records]] = field(default_factory=list)
    builds: list[Build] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class _Part:
    """Triangles, and the shape of the tree over them: None if the GPU builds it."""

    triangles: Integers
    shape: Shape | None

    @property
    def node_count(self) -> int:
        return lbvh_node_count(len(self.triangles)) if self.shape is None else len(self.shape.first)


class Parts:
    """The parts of one scene, from its first geometry on. `by_gpu` leaves the shapes to the GPU."""

    def __init__(self, geometry: Geometry, *, by_gpu: bool) -> None:
        self._moves = Moves(geometry)
        self._whole = None if by_gpu else shape_by_area(*triangle_boxes(geometry)[:2])
        self._of_nodes: list[Shape] = []
        self._at_rest: _Part | None = None

    def follow(self, geometry: Geometry) -> Change:
        """What `geometry` changes, in which nodes may lie elsewhere than in the one before."""
        divides = self._moves.follow(geometry) or self._at_rest is None
        if self._at_rest is None or divides:
            self._at_rest = self._rest()
        rest, moved = self._at_rest, self._moved(divides)
        root = int(len(rest.triangles) > 0 and len(moved.triangles) > 0)
        change = Change(root + rest.node_count + moved.node_count)
        if divides:
            if root:
                count = len(rest.triangles) + len(moved.triangles)
                change.records.append((0, records_of(0, count, change.node_count)))
            self._place(change, rest, 0, root)
        self._place(change, moved, len(rest.triangles), root + rest.node_count)
        return change

    def _place(self, change: Change, part: _Part, first_place: int, first_node: int) -> None:
        if not len(part.triangles):
            return
        change.order.append((first_place, self._moves.listed(part.triangles)))
        if part.shape is None:
            change.builds.append(Build(first_place, len(part.triangles), first_node))
        else:
            change.records.append((first_node, part.shape.records(first_place, first_node)))

    def _rest(self) -> _Part:
        at_rest = ~self._moves.has_moved[self._moves.node_of]
        if self._whole is None:
            return _Part(np.flatnonzero(at_rest), None)
        shape = self._whole.only(at_rest[self._whole.order])
        return _Part(shape.order, shape)

    def _moved(self, divides: bool) -> _Part:
        nodes, node_of = np.flatnonzero(self._moves.has_moved), self._moves.node_of
        has_moved = self._moves.has_moved[node_of]
        if self._whole is None or not len(nodes):
            return _Part(np.flatnonzero(has_moved), None)
        if divides:
            self._of_nodes = _separated(self._whole.only(has_moved[self._whole.order]), node_of, nodes)
        top = shape_by_area(*self._moves.boxes(nodes), largest_leaf=1)
        shape = joined(top, self._of_nodes)
        return _Part(shape.order, shape)


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


def lbvh_node_count(triangles: int) -> int:
    """Nodes of a tree that the GPU builds over so many triangles."""
    return max(2 * -(-triangles // LBVH_LEAF) - 1, 0)


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
