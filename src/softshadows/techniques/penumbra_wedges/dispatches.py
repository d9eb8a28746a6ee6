"""How the work of a frame is cut into dispatches, from sizes the CPU knows: across the image, and along the geometry.

A dispatch does a band of rows of tiles. Where a tile might go round its loops more often than a driver bears, a band
takes several dispatches, and its receivers keep in a buffer what they know in between (walk.wgsl).
"""

from __future__ import annotations

from dataclasses import dataclass

from softshadows.gpu.budget import ROUNDS_OF_DISPATCH, SUBMIT_MS
from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.techniques.penumbra_wedges.edge_buffers import CLUSTER, EdgeBuffers

_FOLDER = "techniques/penumbra_wedges"
TILE = constant(f"{_FOLDER}/tile.wgsl", "TILE")
OBJECT_ROUNDS = constant(f"{_FOLDER}/wedges.wgsl", "OBJECT_ROUNDS")
MOST_BYTES = 2**26
"""Bytes that all receivers in a band keep."""
PRIMITIVES_PER_LOOKUP = 80
"""Edges and triangles of the scene per pixel, in the time of one look-up: 27 spheres of 762 triangles at 192×144."""


@dataclass(frozen=True)
class Dispatches:
    """The first row of tiles of each band, and the end; dispatches per band; all milliseconds, at a rough guess.

    `constants` are those of visibility.wgsl; `state_bytes` holds one band's receivers.
    """

    band_rows: tuple[int, ...]
    parts: int
    milliseconds: float
    state_bytes: int
    constants: dict[str, float]

    @property
    def bands(self) -> int:
        return len(self.band_rows) - 1


def plan(gpu: Gpu, edges: EdgeBuffers, size: tuple[int, int], is_union: bool) -> Dispatches:
    """The dispatches of a frame of this size, for one side of a light."""
    columns, rows = (-(-extent // TILE) for extent in size)
    milliseconds = size[0] * size[1] * (edges.edge_count + edges.triangle_count) / PRIMITIVES_PER_LOOKUP
    milliseconds /= gpu.budget.lookups_per_ms
    bands = min(rows, 1 + int(milliseconds / SUBMIT_MS))

    edge_rounds, state_bytes = (constant(_combination(is_union), name) for name in ("EDGE_ROUNDS", "STATE_BYTES"))
    longest_step = 8 + CLUSTER * edge_rounds  # a cluster, and the way back to it; a tile pauses when this is not left
    parts = -(-_rounds(edges, edge_rounds, is_union) // (ROUNDS_OF_DISPATCH - longest_step))
    row_bytes = columns * TILE**2 * state_bytes
    if parts > 1:
        bands = max(bands, -(-rows // max(MOST_BYTES // row_bytes, 1)))
    return Dispatches(
        band_rows=tuple(rows * band // bands for band in range(bands + 1)),
        parts=max(parts, 1),
        milliseconds=milliseconds,
        state_bytes=-(-rows // bands) * row_bytes if parts > 1 else state_bytes,
        constants={"is_in_parts": parts > 1, "rounds_of_dispatch": ROUNDS_OF_DISPATCH},
    )


def _combination(is_union: bool) -> str:
    """The shader that says how occluders are combined."""
    return f"{_FOLDER}/{'union' if is_union else 'wedges'}.wgsl"


def _rounds(edges: EdgeBuffers, edge_rounds: int, is_union: bool) -> int:
    """Rounds of loops in a tile whose shaft holds the whole scene: each 64 clusters, each cluster and item."""
    clusters = edges.edge_cluster_count + edges.triangle_cluster_count
    walking = clusters + clusters // CLUSTER + 2
    items = walking + edges.triangle_count + edge_rounds * edges.edge_count
    if is_union:
        return items
    sheets = 1 if edges.is_closed.all() else 2  # of an object: what turns its front, and what turns its back
    return sheets * items + (OBJECT_ROUNDS + 3) * edges.silhouette_count  # and a started 64 of each
