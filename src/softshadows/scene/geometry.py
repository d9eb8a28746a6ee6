"""A scene flattened into world-space arrays: the one geometry that the GPU and the ray-traced truth both see."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError
from softshadows.scene.model import Material, Node, Scene

Floats = npt.NDArray[np.float32]

_CHUNK = 1 << 15
"""Triangles or vertices worked on at one time, so that the intermediate numbers stay in the processor's cache."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """World-space triangles, opaque ones first, then those with an alpha cutoff.

    positions (v, 3) float32; triangles (t, 3) uint32; normals (v, 3) float32, zero where the mesh has none (flat);
    texcoords (v, 4) float32, two sets side by side; colors (v, 4) float32; face_normals (t, 3) float32, unit, by
    winding, zero for degenerate triangles; material_index (t,) uint32 into `materials`; opaque_count: triangles before
    the masked ones; node_starts (n + 1,) int64: where each drawn node's triangles begin, and the end.
    """

    positions: Floats
    triangles: npt.NDArray[np.uint32]
    normals: Floats
    texcoords: Floats
    colors: Floats
    face_normals: Floats
    material_index: npt.NDArray[np.uint32]
    materials: list[Material]
    opaque_count: int
    node_starts: npt.NDArray[np.int64]

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


def flatten(scene: Scene) -> Geometry:
    """All nodes of `scene` in world space. Raises SceneError where a transform or its result is not finite."""
    nodes = [node for node in scene.nodes if len(node.mesh.triangles)]
    nodes.sort(key=lambda node: node.mesh.material.alpha_cutoff is not None)  # stable: opaque first
    materials = list({id(node.mesh.material): node.mesh.material for node in nodes}.values())
    index_of = {id(material): index for index, material in enumerate(materials)}

    positions, triangles, normals, texcoords, colors, material_index = [], [], [], [], [], []
    vertex_base = opaque_count = 0
    for node in nodes:
        mesh, count = node.mesh, len(node.mesh.positions)
        world, linear = _world_positions(node)
        corners = mesh.triangles + np.uint32(vertex_base)
        mirrored = np.linalg.det(linear) < 0.0
        positions.append(world)
        triangles.append(corners[:, ::-1] if mirrored else corners)  # keeps the front in front
        normals.append(_world_normals(mesh.normals, linear, count))
        texcoords.append(
            np.zeros((count, 4), np.float32) if mesh.texcoords is None else np.hstack(list(mesh.texcoords))
        )
        colors.append(np.ones((count, 4), np.float32) if mesh.colors is None else mesh.colors)
        material_index.append(np.full(len(mesh.triangles), index_of[id(mesh.material)], np.uint32))
        vertex_base += count
        if mesh.material.alpha_cutoff is None:
            opaque_count += len(mesh.triangles)

    def join(parts: list, width: int, dtype: type) -> np.ndarray:
        return np.ascontiguousarray(np.concatenate(parts), dtype) if parts else np.zeros((0, width), dtype)

    all_positions, all_triangles = join(positions, 3, np.float32), join(triangles, 3, np.uint32)
    return Geometry(
        positions=all_positions,
        triangles=all_triangles,
        normals=join(normals, 3, np.float32),
        texcoords=join(texcoords, 4, np.float32),
        colors=join(colors, 4, np.float32),
        face_normals=_face_normals(all_positions, all_triangles),
        material_index=join(material_index, 1, np.uint32).reshape(-1),
        materials=materials,
        opaque_count=opaque_count,
        node_starts=np.cumsum([0, *(len(node.mesh.triangles) for node in nodes)]),
    )


def _world_positions(node: Node) -> tuple[Floats, np.ndarray]:
    transform = np.asarray(node.transform, np.float64)
    if transform.shape != (4, 4) or not np.isfinite(transform).all():
        raise SceneError(f"node {node.name!r}: transform must be a finite (4, 4) matrix", code="NODE_MATRIX_INVALID")
    linear = transform[:3, :3]
    with np.errstate(over="ignore"):
        world = (node.mesh.positions.astype(np.float64) @ linear.T + transform[:3, 3]).astype(np.float32)
    if len(world) and not (np.abs(world).max() <= 1e12):
        raise SceneError(
            f"node {node.name!r}: world positions must be finite and at most 1e12 metres in size",
            code="ACCESSOR_INVALID_FLOAT",
        )
    return world, linear


def _world_normals(normals: Floats | None, linear: np.ndarray, count: int) -> Floats:
    if normals is None:
        return np.zeros((count, 3), np.float32)
    a, b, c = linear.T
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)  # inverse transpose × determinant
    if np.linalg.det(linear) < 0.0:
        cofactor = -cofactor
    result = np.empty((count, 3), np.float32)
    for start in range(0, count, _CHUNK):
        x, y, z = cofactor @ normals[start : start + _CHUNK].astype(np.float64).T
        _write_unit(result[start : start + _CHUNK], x, y, z)
    return result


def _face_normals(positions: Floats, triangles: npt.NDArray[np.uint32]) -> Floats:
    """Unit normals of (t, 3) triangles by winding, from cross products in float64; zero for degenerate ones."""
    result = np.empty((len(triangles), 3), np.float32)
    columns = [np.ascontiguousarray(positions[:, axis]) for axis in range(3)]
    for start in range(0, len(triangles), _CHUNK):
        a, b, c = triangles[start : start + _CHUNK].T
        origin = [column[a].astype(np.float64) for column in columns]
        ux, uy, uz = (column[b] - base for column, base in zip(columns, origin, strict=True))
        vx, vy, vz = (column[c] - base for column, base in zip(columns, origin, strict=True))
        _write_unit(result[start : start + _CHUNK], uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
    return result


def _write_unit(out: Floats, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> None:
    """Write the unit vectors along (x, y, z), float64, to `out` (n, 3); zero where they have no length."""
    length = np.sqrt(x * x + y * y + z * z)
    length[length == 0.0] = 1.0
    for axis, component in enumerate((x, y, z)):
        out[:, axis] = component / length
