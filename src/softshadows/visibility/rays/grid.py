"""The grid that a tree's boxes lie on."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.gpu.compose import constant
from softshadows.gpu.layout import F32, U32, Struct, Vec3f, dtype
from softshadows.scene.geometry import Geometry

CELLS = 65535.0
MARGIN = 2.0
"""Cells kept free at either end, for what rounding outwards adds."""
SMALLEST_CELL = 2.0**-22
"""A cell's least size over the largest coordinate: the grid's corner, in float32, is off by a quarter of it at most."""
THINNEST = 1e-6
"""A flat scene's thickness, as a share of its diagonal."""
POINT = 1e-12
"""Metres: as if a scene in one point were so large."""

INVOCATIONS = constant("visibility/rays/invocation.wgsl", "INVOCATIONS")
MOST_GROUPS = 65535
"""WebGPU: workgroups along one dimension of a dispatch."""


class TreeGrid(Struct):
    """The grid that a tree's boxes lie on, its counts, and how far the scene reaches from its middle (occluded.wgsl).

    A tree in a light's space has its `low_ws` there. `opaque_count`: triangles before those with alpha masks.
    `solid_count`: the first of them, which belong to solids whose near sides hide nothing that their far sides do not
    (light_tree.py).
    """

    low_ws: Vec3f
    triangle_count: U32
    cells_per_metre: Vec3f
    node_count: U32
    extent: F32
    diagonal: F32
    opaque_count: U32
    solid_count: U32


NODE_COUNT_OFFSET: int = dtype(TreeGrid).fields["node_count"][1]  # type: ignore[index]
"""Bytes: where a build on the GPU puts the count that it alone knows."""


def grid_over(
    geometry: Geometry, node_count: int, bounds: npt.NDArray[np.float64] | None = None, solid_count: int = 0
) -> TreeGrid:
    """The grid for where the triangles are now; `bounds` (2, 3) are theirs where the tree is not in world space."""
    low, high = corners = geometry.bounds if bounds is None else bounds
    across = np.maximum(high - low, max(THINNEST * geometry.diagonal, POINT))
    cell = np.maximum(across / (CELLS - 2.0 * MARGIN), SMALLEST_CELL * np.abs(corners).max())
    return TreeGrid(
        low_ws=tuple(low - MARGIN * cell),
        triangle_count=len(geometry.triangles),
        cells_per_metre=tuple(1.0 / cell),
        node_count=node_count,
        extent=geometry.extent,
        diagonal=geometry.diagonal,
        opaque_count=geometry.opaque_count,
        solid_count=solid_count,
    )


def groups_of(count: int, size: int = INVOCATIONS) -> tuple[int, int]:
    """Workgroups of `size` along x and y that hold `count` invocations."""
    groups = max(-(-count // size), 1)
    across = min(groups, MOST_GROUPS)
    return across, -(-groups // across)
