"""The shape of a tree of boxes over triangles, chosen on the CPU by the surface-area heuristic.

Binned (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), level by level: all nodes of a
level are split at once by array operations, so that no step runs once per triangle or per node.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from softshadows.visibility.rays.shape import MOST_IN_LEAF, TWO_LEAVES, Integers, Shape, joined

Floats = npt.NDArray[np.float32]

BINS = 16
LARGE = 0.25
"""A large triangle's extent, as a share of the scene's longest side: measured, docs/decisions/0017-rays.md."""
NODE_COST = 0.5
"""What visiting a node costs, over testing a triangle. Between 0.25 and 2 the choice moves the rays' speed by 5 %."""


@dataclass(frozen=True, eq=False)
class _Level:
    """Nodes of one depth: first, end, and the first one's place among the next level's nodes (-1 for a leaf)."""

    first: Integers
    end: Integers
    child: Integers


def shape_by_area(low: Floats, high: Floats, largest_leaf: int = MOST_IN_LEAF) -> Shape:
    """The tree for the boxes with corners `low` and `high`, (3, t) float32 each: rows x, y, z. No leaf holds more than
    `largest_leaf`.

    Boxes that are large for the scene, such as a ground's, have a tree of their own beside that of the others: middles
    do not tell them apart, and each would stretch all nodes above it.
    """
    sizes = (high - low).max(axis=0, initial=0.0)
    is_large = sizes > LARGE * (high.max(axis=1, initial=-np.inf) - low.min(axis=1, initial=np.inf)).max()
    if is_large.all() or not is_large.any():
        return _shape(low, high, largest_leaf)
    parts = []
    for chosen in (np.flatnonzero(~is_large), np.flatnonzero(is_large)):
        part = _shape(low[:, chosen], high[:, chosen], largest_leaf)
        parts.append(replace(part, order=chosen[part.order]))
    return joined(TWO_LEAVES, parts)


def _shape(low: Floats, high: Floats, largest_leaf: int) -> Shape:
    """The same for boxes of similar sizes."""
    count = low.shape[1]
    order = np.arange(count)
    middle = (low + high) * np.float32(0.5)
    levels: list[_Level] = []
    first, end = np.array([0]), np.array([count])
    while len(first):
        split = _splits(low, high, middle, order, first, end, largest_leaf)
        is_inner = split > first
        child = np.where(is_inner, 2 * (np.cumsum(is_inner) - 1), -1)
        levels.append(_Level(first, end, child))
        first, end = (
            np.stack([low_end, high_end], axis=1)[is_inner].ravel()
            for low_end, high_end in ((first, split), (split, end))
        )
    return _in_preorder(levels, order)


def _splits(
    low: Floats,
    high: Floats,
    middle: Floats,
    order: Integers,
    first: Integers,
    end: Integers,
    largest_leaf: int,
) -> Integers:
    """Where each node's triangles are cut in two, or its `first` for a leaf. Sorts `order` so that they can be."""
    split = first.copy()
    large = np.flatnonzero(end - first > 1)
    if not len(large):
        return split
    counts = (end - first)[large]
    starts = np.cumsum(counts) - counts
    node = np.repeat(np.arange(len(large)), counts)
    places = np.arange(len(node)) + np.repeat(first[large] - starts, counts)

    # Sort each node's triangles by bin, along the axis on which their middles lie farthest apart.
    triangle = order[places]
    middles = middle[:, triangle]
    least = np.minimum.reduceat(middles, starts, axis=1)
    extent = np.maximum.reduceat(middles, starts, axis=1) - least
    axis = extent.argmax(axis=0)
    scale = np.float32(BINS) / np.maximum(extent.max(axis=0), np.float32(1e-30))
    along = middles[axis[node], np.arange(len(node))]
    bins = np.clip((along - least[axis, np.arange(len(large))][node]) * scale[node], 0, BINS - 1).astype(np.int64)
    key = node * BINS + bins
    ranked = np.sort((key << 32) | np.arange(len(key)))
    triangle = triangle[ranked & 0xFFFFFFFF]
    order[places] = triangle

    # The boxes of the bins, and what every cut between them costs.
    filled, at, in_bin = np.unique(ranked >> 32, return_index=True, return_counts=True)
    number = np.zeros(len(large) * BINS, np.int64)
    number[filled] = in_bin
    boxes = np.full((2, 3, len(large) * BINS), np.inf, np.float32)
    boxes[1] = -np.inf
    boxes[0][:, filled] = np.minimum.reduceat(low[:, triangle], at, axis=1)
    boxes[1][:, filled] = np.maximum.reduceat(high[:, triangle], at, axis=1)
    boxes, number = boxes.reshape(2, 3, -1, BINS), number.reshape(-1, BINS)
    before, after = _areas(boxes), _areas(boxes[..., ::-1])[:, ::-1]
    number_before = np.cumsum(number, axis=1)
    number_after = number_before[:, -1:] - number_before
    with np.errstate(invalid="ignore"):
        cost = before[:, :-1] * number_before[:, :-1] + after[:, 1:] * number_after[:, :-1]
    cost[(number_before[:, :-1] == 0) | (number_after[:, :-1] == 0)] = np.inf
    best = cost.argmin(axis=1)
    rows = np.arange(len(large))
    whole = before[:, -1]
    is_leaf = (counts <= largest_leaf) & (whole * counts <= NODE_COST * 2.0 * whole + cost[rows, best])
    cut = np.where(np.isinf(cost[rows, best]), counts // 2, number_before[rows, best])  # all in one place: halve them
    split[large] += np.where(is_leaf, 0, cut)
    return split


def _areas(boxes: Floats) -> Floats:
    """(n, BINS): half the surface of what the first k + 1 bins of boxes (2, 3, n, BINS) fill, 0 for nothing."""
    x, y, z = np.maximum.accumulate(boxes[1], axis=2) - np.minimum.accumulate(boxes[0], axis=2)
    with np.errstate(invalid="ignore"):
        area = x * y + y * z + z * x
    return np.where(x >= 0.0, area, np.float32(0.0))


def _in_preorder(levels: list[_Level], order: Integers) -> Shape:
    """Nodes numbered from the top down: sizes of the trees from below, then places from above."""
    sizes: list[Integers] = []
    below = np.zeros(0, np.int64)
    for level in reversed(levels):
        size = np.ones(len(level.child), np.int64)
        inner = np.flatnonzero(level.child >= 0)
        size[inner] += below[level.child[inner]] + below[level.child[inner] + 1]
        sizes.append(size)
        below = size
    sizes.reverse()

    total = int(sizes[0][0])
    first, end, skip = (np.empty(total, np.int64) for _ in range(3))
    is_leaf = np.empty(total, bool)
    place = np.zeros(1, np.int64)
    for depth, (level, size) in enumerate(zip(levels, sizes, strict=True)):
        first[place], end[place], skip[place], is_leaf[place] = level.first, level.end, place + size, level.child < 0
        if depth + 1 < len(levels):
            inner = np.flatnonzero(level.child >= 0)
            children = place[inner] + 1
            seconds = children + sizes[depth + 1][level.child[inner]]
            place = np.stack([children, seconds], axis=1).ravel()
    return Shape(order, first, end, skip, is_leaf)
