"""The shape of a tree of boxes over triangles: which triangles each node holds, and where the walk goes on from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]
Records = npt.NDArray[np.uint32]
LEAF = 0x80000000
LEAF_COUNT_SHIFT = 28
MOST_IN_LEAF = 8
"""Triangles that a leaf's link can count (tree_node.wgsl)."""
MOST_TRIANGLES = 1 << LEAF_COUNT_SHIFT
"""Places that a leaf's link can name."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A tree without bounds, nodes in preorder: a node's first child follows it, its second one follows the first's
    tree.

    order (t,): the triangles, leaf by leaf; first, end (n,): a node's triangles are order[first:end]; skip (n,): the
    node that follows its tree; is_leaf (n,) bool. All whole numbers int64.
    """

    order: Integers
    first: Integers
    end: Integers
    skip: Integers
    is_leaf: npt.NDArray[np.bool_]

    @staticmethod
    def empty() -> Shape:
        """A tree over nothing."""
        none = np.zeros(0, np.int64)
        return Shape(none, none, none, none, np.zeros(0, bool))

    def only(self, stays: npt.NDArray[np.bool_]) -> Shape:
        """The tree of those triangles of `order` that stay, (t,): without nodes that hold none, or all that a child
        holds. No nodes at all if no triangle stays."""
        places = starts_of(stays)
        first, end = places[self.first], places[self.end]
        count = end - first
        in_first_child = np.append(count[1:], 0)
        divides = (in_first_child > 0) & (in_first_child < count)
        is_needed = np.where(self.is_leaf, count > 0, divides)
        nodes = starts_of(is_needed)
        skip = nodes[self.skip[is_needed]]
        return Shape(self.order[stays], first[is_needed], end[is_needed], skip, self.is_leaf[is_needed])

    def records(self, first_place: int = 0, first_node: int = 0) -> Records:
        """(n, 4) uint32, what refit.wgsl reads of every node, for a tree that begins at `first_node` and at
        `first_place` of the order: first place, end and link (tree_node.wgsl)."""
        first, end = self.first + first_place, self.end + first_place
        leaf = LEAF | (end - first - 1) << LEAF_COUNT_SHIFT | first
        return records_of(first, end, np.where(self.is_leaf, leaf, self.skip + first_node))


def records_of(first: npt.ArrayLike, end: npt.ArrayLike, link: npt.ArrayLike) -> Records:
    """(n, 4) uint32: nodes as refit.wgsl reads them."""
    return np.stack([np.atleast_1d(part) for part in (first, end, link, np.zeros_like(link))], axis=1).astype(np.uint32)


TWO_LEAVES = Shape(
    order=np.array([0, 1]),
    first=np.array([0, 0, 1]),
    end=np.array([2, 1, 2]),
    skip=np.array([3, 2, 3]),
    is_leaf=np.array([False, True, True]),
)
"""A root and two leaves with a part each."""


def joined(top: Shape, parts: Sequence[Shape]) -> Shape:
    """One tree of many: `top` holds one part in each leaf, and that part's tree takes the leaf's place."""
    parts = [parts[part] for part in top.order]
    node_counts = np.array([len(part.first) for part in parts])
    triangle_counts = np.array([len(part.order) for part in parts])
    places = starts_of(triangle_counts)
    leaves, inner = np.flatnonzero(top.is_leaf), np.flatnonzero(~top.is_leaf)
    takes = np.ones(len(top.first), np.int64)
    takes[leaves] = node_counts
    nodes = starts_of(takes)

    first, end, skip = (np.empty(nodes[-1], np.int64) for _ in range(3))
    is_leaf = np.zeros(nodes[-1], bool)
    at = nodes[inner]
    first[at], end[at], skip[at] = places[top.first[inner]], places[top.end[inner]], nodes[top.skip[inner]]
    at = ranges(nodes[leaves], node_counts)
    first_place, first_node = np.repeat(places[:-1], node_counts), np.repeat(nodes[leaves], node_counts)
    first[at] = np.concatenate([part.first for part in parts]) + first_place
    end[at] = np.concatenate([part.end for part in parts]) + first_place
    skip[at] = np.concatenate([part.skip for part in parts]) + first_node
    is_leaf[at] = np.concatenate([part.is_leaf for part in parts])
    return Shape(np.concatenate([part.order for part in parts]), first, end, skip, is_leaf)


def starts_of(counts: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> Integers:
    """(n + 1,): where each of n runs of these lengths starts, and where the last one ends."""
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def ranges(starts: Integers, counts: Integers) -> Integers:
    """The numbers of all runs, one run after the other: starts[0], starts[0] + 1 ... up to counts[0] of them."""
    return np.repeat(starts - starts_of(counts)[:-1], counts) + np.arange(counts.sum())
