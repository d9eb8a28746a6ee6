"""A scene flattened into world-space arrays: the one geometry that the GPU and the ray-traced truth both see."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError
from softshadows.scene.model import Material, Mesh, Node, Scene
from softshadows.scene.solids import is_solid

Floats = npt.NDArray[np.float32]

_CHUNK = 1 << 15
"""Triangles or vertices worked on at one time, so that the intermediate numbers stay in the processor's cache."""

FLATTENED = 1e-6
"""Determinant over the cube of a transform's norm (0.19 for a rotation) below which float32 may turn faces around."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """World-space triangles: those of solid nodes first (`solids.py`), then other opaque ones, then those with an alpha
    cutoff.

    positions (v, 3) float32; triangles (t, 3) uint32; normals (v, 3) float32, zero where the mesh has none (flat);
    texcoords (v, 4) float32, two sets side by side; colors (v, 4) float32; face_normals (t, 3) float32, unit, by
    winding, zero for degenerate triangles; material_index (t,) uint32 into `materials`; solid_count: triangles of solid
    nodes; opaque_count: triangles before the masked ones; solid_boxes (k, 2, 3) float32: low and high corner of each
    solid node; node_starts (n + 1,) int64: where each drawn node's triangles begin, and the end; meshes: each drawn
    node's mesh, whose vertices follow each other in the same order.
    """

    positions: Floats
    triangles: npt.NDArray[np.uint32]
    normals: Floats
    texcoords: Floats
    colors: Floats
    face_normals: Floats
    material_index: npt.NDArray[np.uint32]
    materials: list[Material]
    solid_count: int
    opaque_count: int
    solid_boxes: Floats
    node_starts: npt.NDArray[np.int64]
    meshes: list[Mesh]

    @cached_property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) lowest and highest corner of all vertices; zeros without vertices."""
        if not len(self.positions):
            return np.zeros((2, 3))
        return np.stack([self.positions.min(axis=0), self.positions.max(axis=0)]).astype(np.float64)

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal, metres; 0 without vertices."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    @cached_property
    def middle(self) -> npt.NDArray[np.float64]:
        """(3,): the middle of the bounding box, so coarsely rounded that it is exact to subtract for almost every
        vertex.

        A scene about the origin has its middle there.
        """
        grid = 2.0 ** np.ceil(np.log2(max(self.diagonal, 1e-30)))
        return np.round(self.bounds.mean(axis=0) / grid) * grid

    @property
    def extent(self) -> float:
        """Largest coordinate of any vertex, in metres from `middle`."""
        return float(np.abs(self.bounds - self.middle).max())


def flatten(scene: Scene) -> Geometry:
    """All nodes of `scene` in world space. Raises SceneError where a transform or its result is not finite."""
    nodes = [node for node in scene.nodes if len(node.mesh.triangles)]
    solid = _solid_nodes(nodes)
    nodes.sort(key=lambda node: (id(node) not in solid, node.mesh.material.alpha_cutoff is not None))  # stable
    materials = list({id(node.mesh.material): node.mesh.material for node in nodes}.values())
    index_of = {id(material): index for index, material in enumerate(materials)}

    vertex_count = sum(len(node.mesh.positions) for node in nodes)
    triangle_count = sum(len(node.mesh.triangles) for node in nodes)
    positions = np.empty((vertex_count, 3), np.float32)
    normals, texcoords = np.zeros((vertex_count, 3), np.float32), np.zeros((vertex_count, 4), np.float32)
    colors = np.ones((vertex_count, 4), np.float32)
    triangles = np.empty((triangle_count, 3), np.uint32)
    material_index = np.empty(triangle_count, np.uint32)

    vertex_base = triangle_base = solid_count = opaque_count = 0
    solid_boxes = []
    for node in nodes:
        mesh, linear = node.mesh, _transform(node)[:3, :3]
        vertices = slice(vertex_base, vertex_base + len(mesh.positions))
        faces = slice(triangle_base, triangle_base + len(mesh.triangles))
        _write_world_positions(positions[vertices], node)
        if mesh.normals is not None:
            _write_world_normals(normals[vertices], mesh.normals, linear)
        if mesh.texcoords is not None:
            texcoords[vertices, :2], texcoords[vertices, 2:] = mesh.texcoords
        if mesh.colors is not None:
            colors[vertices] = mesh.colors
        mirrored = np.linalg.det(linear) < 0.0
        corners = mesh.triangles[:, ::-1] if mirrored else mesh.triangles  # keeps the front in front
        np.add(corners, np.uint32(vertex_base), out=triangles[faces])
        material_index[faces] = index_of[id(mesh.material)]
        vertex_base, triangle_base = vertices.stop, faces.stop
        if mesh.material.alpha_cutoff is None:
            opaque_count = triangle_base
        if id(node) in solid:
            solid_count = triangle_base
            solid_boxes.append((positions[vertices].min(axis=0), positions[vertices].max(axis=0)))

    return Geometry(
        positions=positions,
        triangles=triangles,
        normals=normals,
        texcoords=texcoords,
        colors=colors,
        face_normals=_face_normals(positions, triangles),
        material_index=material_index,
        materials=materials,
        solid_count=solid_count,
        opaque_count=opaque_count,
        solid_boxes=np.array(solid_boxes, np.float32).reshape(-1, 2, 3),
        node_starts=np.cumsum([0, *(len(node.mesh.triangles) for node in nodes)]),
        meshes=[node.mesh for node in nodes],
    )


def _solid_nodes(nodes: list[Node]) -> set[int]:
    """The ids of nodes that place a solid mesh and keep its volume."""
    solid_meshes = {id(mesh) for mesh in {id(node.mesh): node.mesh for node in nodes}.values() if is_solid(mesh)}

    def keeps_volume(linear: np.ndarray) -> bool:
        return abs(np.linalg.det(linear)) > FLATTENED * np.linalg.norm(linear) ** 3

    return {id(node) for node in nodes if id(node.mesh) in solid_meshes and keeps_volume(_transform(node)[:3, :3])}


def _transform(node: Node) -> npt.NDArray[np.float64]:
    transform = np.asarray(node.transform, np.float64)
    if transform.shape != (4, 4) or not np.isfinite(transform).all():
        raise SceneError(f"node {node.name!r}: transform must be a finite (4, 4) matrix", code="NODE_MATRIX_INVALID")
    return transform


def _write_world_positions(out: Floats, node: Node) -> None:
    transform = _transform(node)
    for start in range(0, len(out), _CHUNK):
        part = slice(start, start + _CHUNK)
        with np.errstate(over="ignore"):
            out[part] = node.mesh.positions[part].astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]
        if not np.abs(out[part]).max() <= 1e12:
            raise SceneError(
                f"node {node.name!r}: world positions must be finite and at most 1e12 metres in size",
                code="ACCESSOR_INVALID_FLOAT",
            )


def _write_world_normals(out: Floats, normals: Floats, linear: np.ndarray) -> None:
    a, b, c = linear.T
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)  # inverse transpose × determinant
    if np.linalg.det(linear) < 0.0:
        cofactor = -cofactor
    for start in range(0, len(out), _CHUNK):
        x, y, z = cofactor @ normals[start : start + _CHUNK].T.astype(np.float64, order="C")
        _write_unit(out[start : start + _CHUNK], x, y, z)


def _face_normals(positions: Floats, triangles: npt.NDArray[np.uint32]) -> Floats:
    """Unit normals of (t, 3) triangles by winding, from cross products in float64; zero for degenerate ones."""
    result = np.empty((len(triangles), 3), np.float32)
    for start in range(0, len(triangles), _CHUNK):
        corners = positions.take(triangles[start : start + _CHUNK].astype(np.intp), axis=0)
        a, b, c = corners.transpose(1, 2, 0).astype(np.float64, order="C")  # rows x, y, z of each corner
        (ux, uy, uz), (vx, vy, vz) = b - a, c - a
        _write_unit(result[start : start + _CHUNK], uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
    return result


def _write_unit(out: Floats, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> None:
    """Write the unit vectors along (x, y, z), float64, to `out` (n, 3); zero where they have no length."""
    length = np.sqrt(x * x + y * y + z * z)
    length[length == 0.0] = 1.0
    for axis, component in enumerate((x, y, z)):
        out[:, axis] = component / length
