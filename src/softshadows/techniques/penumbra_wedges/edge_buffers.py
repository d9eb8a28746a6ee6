"""The scene's edges and objects on the GPU: written when the scene changes, whatever the lights do.

An object is what hides the light as one: the triangles of a node that are connected. A closed one is one
silhouette. Any other is two, its triangles that turn their front to the light and those that turn their back: each of
the two is a sheet, and for a flat card one of them is empty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, U32, Struct, Vec3f, dtype
from softshadows.gpu.program import Resource
from softshadows.scene.edges import MeshEdges, edges_of
from softshadows.scene.geometry import Geometry

CLUSTER = constant("techniques/penumbra_wedges/silhouettes.wgsl", "CLUSTER")
"""Edges or triangles that are looked at together."""

Numbers = npt.NDArray[np.int64]


class WedgeEdge(Struct):
    """An edge in light units, cut off at the light's plane, and its weight as a silhouette of the light's centre.

    `front`, `back`: by how many layers of triangles that turn their front, or their back, to the light's centre its
    left side has more than its right; `normal`: a × b of the whole edge; `is_silhouette`: of what the run asks for.
    """

    a: Vec3f
    front: F32
    b: Vec3f
    back: F32
    normal: Vec3f
    is_silhouette: U32


class WedgeCluster(Struct):
    """A run of edges or triangles, and the box around what of it matters: low above high where nothing does."""

    low: Vec3f
    first: U32
    high: Vec3f
    count: U32


class WedgeObject(Struct):
    """A silhouette: its box in light units, its clusters, and how much the two kinds of layers count."""

    low: Vec3f
    first_edge_cluster: U32
    high: Vec3f
    edge_clusters: U32
    first_triangle_cluster: U32
    triangle_clusters: U32
    front: F32
    back: F32
    is_closed: U32
    unused_0: U32
    unused_1: U32
    unused_2: U32


@dataclass(frozen=True, eq=False)
class Placed:
    """A node's edges among the scene's: where its vertices, triangles and edges begin, and whether it is mirrored."""

    edges: MeshEdges
    vertex: int
    triangle: int
    is_mirrored: bool


class EdgeBuffers:
    """Edges, triangles and clusters of all objects, and the objects' boxes.

    edge_records: array<vec4u>, two ends, two triangles as `_side`; triangle_records: array<vec4u>, three edges as
    `_side`, the triangle; cluster_ranges: array<vec2u>, first and count of each cluster of edges, then of triangles.
    """

    def __init__(self, gpu: Gpu, geometry: Geometry) -> None:
        self._gpu = gpu
        self._signature: list[tuple[int, bool]] | None = None
        self.update(geometry)

    def update(self, geometry: Geometry) -> bool:
        """Take in a changed scene. True where the buffers are new ones: moving nodes changes only the boxes."""
        placed = _place(geometry)
        signature = [(id(node.edges), node.is_mirrored) for node in placed]
        is_new = signature != self._signature
        if is_new:
            self._placed, self._signature = placed, signature
            self._build(placed, len(geometry.triangles))
        self._boxes = _object_boxes(geometry, self._corners)
        return is_new

    def _build(self, placed: list[Placed], triangle_count: int) -> None:
        edge_base = np.cumsum([0, *(len(node.edges.vertices) for node in placed)])
        base = [int(first) for first in edge_base[:-1]]
        edge_records = [_edge_records(node) for node in placed]
        triangle_records = [_triangle_records(node, first) for node, first in zip(placed, base, strict=True)]
        edge_starts = _joined([node.edges.edge_starts for node in placed])
        triangle_starts = _joined([node.edges.triangle_starts for node in placed])
        edge_ranges, self._edge_clusters = _clusters(edge_starts)
        triangle_ranges, self._triangle_clusters = _clusters(triangle_starts)
        self._triangle_clusters[0] += len(edge_ranges)
        self._corners = (_stacked(triangle_records, 4)[:, 3], triangle_starts[:-1])
        self.is_closed = np.concatenate([np.zeros(0, bool), *(node.edges.is_closed for node in placed)])
        self.is_card = np.concatenate([np.zeros(0, bool), *(node.edges.is_card for node in placed)])
        self.edge_count, self.triangle_count = int(edge_base[-1]), triangle_count
        self.edge_cluster_count, self.triangle_cluster_count = len(edge_ranges), len(triangle_ranges)
        self.bytes = 0
        self.edge_records = self._upload(_stacked(edge_records, 4), "the edges")
        self.triangle_records = self._upload(_stacked(triangle_records, 4), "the triangles' edges")
        self.cluster_ranges = self._upload(np.concatenate([edge_ranges, triangle_ranges]), "the clusters of edges")

    def _upload(self, array: np.ndarray, what: str) -> wgpu.GPUBuffer:
        data = np.ascontiguousarray(array, np.uint32)
        size = max(data.nbytes, 16)
        buffer = self._gpu.storage_buffer(size, what)
        self.bytes += size
        if data.nbytes:
            self._gpu.write(buffer, 0, data, what="scene")
        return buffer

    @property
    def cluster_count(self) -> int:
        """Clusters of edges and of triangles."""
        return self.edge_cluster_count + self.triangle_cluster_count

    @property
    def resources(self) -> dict[str, Resource]:
        """What silhouettes.wgsl declares of them."""
        return {
            "edge_records": self.edge_records,
            "triangle_records": self.triangle_records,
            "cluster_ranges": self.cluster_ranges,
        }

    @property
    def silhouette_count(self) -> int:
        """Silhouettes of the scene, for any light."""
        return int(len(self.is_closed) + (~self.is_closed).sum())

    def silhouettes(self, to_light: np.ndarray, center: np.ndarray) -> np.ndarray:
        """WedgeObjects as a light sees them, nearest first; `to_light` (3, 3) turns metres from `center` to its units.

        Forest et al. leave the order open; overlaps are estimated best while rectangles are small.
        """
        low, high = self._boxes
        middle, half = (low + high) / 2.0 - center, (high - low) / 2.0
        local, reach = middle @ to_light.T, half @ np.abs(to_light).T
        count = len(self.is_closed)
        index = np.concatenate([np.arange(count), np.flatnonzero(~self.is_closed)])
        is_back = np.arange(len(index)) >= count
        order = np.lexsort((is_back, index, np.linalg.norm(middle, axis=1)[index]))
        index, is_back = index[order], is_back[order]
        closed = self.is_closed[index]
        result = np.zeros(len(index), dtype(WedgeObject))
        result["low"], result["high"] = (local - reach)[index], (local + reach)[index]
        result["first_edge_cluster"], result["edge_clusters"] = self._edge_clusters[:, index]
        result["first_triangle_cluster"], result["triangle_clusters"] = self._triangle_clusters[:, index]
        result["front"] = np.where(closed, 0.5, np.where(is_back, 0.0, 1.0))
        result["back"] = np.where(closed, 0.5, np.where(is_back, 1.0, 0.0))
        result["is_closed"] = closed
        return result


def _place(geometry: Geometry) -> list[Placed]:
    """The drawn nodes' edges, in the scene's order."""
    placed, vertex = [], 0
    for mesh, triangle in zip(geometry.meshes, geometry.node_starts[:-1], strict=True):
        edges = edges_of(mesh)
        is_mirrored = False
        if len(edges.order):  # `flatten` turns the triangles of a mirrored node around
            first = int(edges.order[0])
            is_mirrored = int(geometry.triangles[triangle + first, 0]) - vertex != int(mesh.triangles[first, 0])
        placed.append(Placed(edges, vertex, int(triangle), is_mirrored))
        vertex += len(mesh.positions)
    return placed


def _side(index: Numbers, is_reversed: npt.NDArray[np.bool_]) -> Numbers:
    """An index with, as its lowest bit, whether triangle and edge run against each other."""
    return 2 * index + is_reversed


def _edge_records(node: Placed) -> Numbers:
    """(e, 4): two vertices, two triangles counted from 1, 0 for none."""
    edges = node.edges
    triangles = np.where(edges.triangles < 0, 0, edges.triangles + node.triangle + 1)
    sides = np.where(triangles == 0, 0, _side(triangles, edges.is_forward == node.is_mirrored))
    return np.hstack([edges.vertices + node.vertex, sides])


def _triangle_records(node: Placed, edge_base: int) -> Numbers:
    """(t, 4): three edges, the triangle."""
    edges = node.edges
    if not len(edges.order):
        return np.zeros((0, 4), np.int64)
    beside = edges.triangles[edges.triangle_edges]  # (t, 3, 2)
    is_second = beside[..., 1] == edges.order[:, None]
    forward = np.where(is_second, edges.is_forward[edges.triangle_edges, 1], edges.is_forward[edges.triangle_edges, 0])
    sides = _side(edges.triangle_edges + edge_base, forward == node.is_mirrored)
    return np.hstack([sides, edges.order[:, None] + node.triangle])


def _stacked(parts: list[Numbers], columns: int) -> Numbers:
    return np.concatenate([np.zeros((0, columns), np.int64), *parts])


def _joined(starts: list[Numbers]) -> Numbers:
    """Where objects begin in all nodes' lists together, and the end."""
    ends = np.cumsum([0, *(int(part[-1]) for part in starts)])
    return np.concatenate([*(part[:-1] + end for part, end in zip(starts, ends, strict=False)), ends[-1:]])


def _clusters(starts: Numbers) -> tuple[Numbers, Numbers]:
    """(c, 2) first and count of every object's clusters; (2, o) each object's first cluster, and how many it has."""
    sizes = np.diff(starts)
    counts = -(-sizes // CLUSTER)
    first_cluster = np.cumsum(counts) - counts
    owner = np.repeat(np.arange(len(sizes)), counts)
    within = (np.arange(len(owner)) - first_cluster[owner]) * CLUSTER
    ranges = np.stack([starts[:-1][owner] + within, np.minimum(sizes[owner] - within, CLUSTER)], axis=1)
    return ranges, np.stack([first_cluster, counts])


def _object_boxes(geometry: Geometry, corners: tuple[Numbers, Numbers]) -> tuple[np.ndarray, np.ndarray]:
    """(o, 3) float64 low and high corners of the objects, world space; from triangles sorted by object, and starts."""
    triangles, starts = corners
    if not len(triangles):
        return np.zeros((0, 3)), np.zeros((0, 3))
    position = geometry.positions.take(geometry.triangles[triangles].astype(np.intp), axis=0)
    low, high = position.min(axis=1), position.max(axis=1)
    return (
        np.minimum.reduceat(low, starts, axis=0).astype(np.float64),
        np.maximum.reduceat(high, starts, axis=0).astype(np.float64),
    )
