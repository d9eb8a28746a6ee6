"""Primitives for the built-in scenes: closed, outward-facing solids, and the meshes made of them.

A `Solid` is the bare surface: vertices shared between triangles, every edge between exactly two of them. `mesh` turns
it into a Mesh with smooth normals wherever faces meet at less than the crease angle: shape and shading are said once.
Metres, y up, counter-clockwise seen from outside.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from softshadows.scene.camera import Camera
from softshadows.scene.lights import Light
from softshadows.scene.model import Material, Mesh, Node, Scene
from softshadows.scene.vectors import VectorLike

Floats = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int64]


class Solid(NamedTuple):
    """positions (n, 3) float64, triangles (m, 3) int64."""

    positions: Floats
    triangles: Triangles


def signed_volume(positions: npt.NDArray, triangles: npt.NDArray) -> float:
    """Volume enclosed by a closed surface, m³; negative where the winding faces inward."""
    a, b, c = np.asarray(positions, np.float64)[triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def outward(positions: npt.NDArray, triangles: npt.NDArray) -> Solid:
    """The solid with coinciding vertices joined and collapsed triangles gone, wound so that its faces look outward."""
    _, first, joined = np.unique(np.round(positions, 7), axis=0, return_index=True, return_inverse=True)
    triangles = first[joined.reshape(-1)][triangles]
    a, b, c = triangles.T
    used, triangles = np.unique(triangles[(a != b) & (b != c) & (c != a)], return_inverse=True)
    solid = Solid(np.asarray(positions, np.float64)[used], triangles.reshape(-1, 3))
    return solid if signed_volume(*solid) > 0.0 else Solid(solid.positions, solid.triangles[:, ::-1])


def place(
    solid: Solid, move: VectorLike = (0, 0, 0), *, turn: float = 0.0, tilt: float = 0.0, scale: float = 1.0
) -> Solid:
    """`solid` scaled, then tilted about z, turned about y (degrees), then moved."""
    matrix = transform(move, turn=turn, tilt=tilt, scale=scale)
    return Solid(solid.positions @ matrix[:3, :3].T + matrix[:3, 3], solid.triangles)


def transform(
    move: VectorLike = (0, 0, 0), *, turn: float = 0.0, tilt: float = 0.0, scale: float = 1.0
) -> npt.NDArray[np.float64]:
    """(4, 4) matrix that scales, tilts about z, turns about y (degrees), then moves."""
    (cy, sy), (cz, sz) = [(np.cos(angle), np.sin(angle)) for angle in np.radians([turn, tilt])]
    matrix = np.eye(4)
    matrix[:3, :3] = (
        scale * np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    )
    matrix[:3, 3] = move
    return matrix


def join(*solids: Solid) -> Solid:
    """Several solids as one; they may touch or overlap, each stays closed by itself."""
    offsets = np.cumsum([0, *(len(solid.positions) for solid in solids)])
    return Solid(
        np.concatenate([solid.positions for solid in solids]),
        np.concatenate([solid.triangles + offset for solid, offset in zip(solids, offsets, strict=False)]),
    )


def mesh(solid: Solid, material: Material, *, crease: float = 40.0, tile: float | None = None, name: str = "") -> Mesh:
    """`solid` as a Mesh: normals are smooth across edges bent by less than `crease` degrees, and split at sharper ones.

    `tile` gives it texture coordinates, projected along the axis nearest to each normal: one repeat in so many metres.
    """
    triangles = solid.triangles
    corner = solid.positions[triangles]
    area_normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(area_normal, axis=1, keepdims=True)
    face_normal = area_normal / np.where(length > 0.0, length, 1.0)

    # Every pair of corners that share a vertex, by sorting corners and walking the runs of equal vertices.
    vertex = triangles.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    valence = np.bincount(vertex, minlength=len(solid.positions))
    start = np.concatenate([[0], np.cumsum(valence)[:-1]])
    partners = valence[vertex]
    own = np.repeat(np.arange(len(vertex)), partners)
    step = np.arange(partners.sum()) - np.repeat(np.cumsum(partners) - partners, partners)
    other = order[start[vertex[own]] + step]

    smooth = np.einsum("ij,ij->i", face_normal[own // 3], face_normal[other // 3]) > np.cos(np.radians(crease))
    normals = np.stack(
        [np.bincount(own[smooth], area_normal[other[smooth] // 3, axis], len(vertex)) for axis in range(3)], axis=1
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)

    keys = np.column_stack([vertex, np.round(normals * 1e4).astype(np.int64)])
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    positions, normals = solid.positions[vertex[first]], normals[first]
    return Mesh(
        positions=positions.astype(np.float32),
        triangles=index.reshape(-1, 3).astype(np.uint32),
        normals=normals.astype(np.float32),
        texcoords=None if tile is None else _box_projected(positions / tile, normals),
        material=material,
        name=name or material.name,
    )


def _box_projected(positions: Floats, normals: Floats) -> npt.NDArray[np.float32]:
    """(2, n, 2): u and v along the two axes across the normal's largest component; v runs downward on walls."""
    axis = np.abs(normals).argmax(axis=1)
    u = np.where(axis == 0, positions[:, 2], positions[:, 0])
    v = np.where(axis == 1, positions[:, 2], -positions[:, 1])
    return np.stack([np.column_stack([u, v])] * 2).astype(np.float32)


def node(
    solid: Solid,
    material: Material,
    move: VectorLike = (0, 0, 0),
    *,
    crease: float = 40.0,
    turn: float = 0.0,
    name: str = "",
) -> Node:
    """A node that places `solid`, meshed with `material`, at `move` after a turn about y (degrees)."""
    made = mesh(solid, material, crease=crease, name=name)
    return Node(made, transform(move, turn=turn), name=made.name)


def scene(nodes: list[Node], light: Light, camera: Camera, name: str) -> Scene:
    """A scene with copies of its materials, so that changing one changes no other scene made from this module's."""
    materials = {id(node.mesh.material): replace(node.mesh.material) for node in nodes}
    for made in {id(node.mesh): node.mesh for node in nodes}.values():
        made.material = materials[id(made.material)]
    return Scene(nodes, [light], camera, name=name)


def floor(half: float, material: Material, *, y: float = 0.0) -> Node:
    """A single-sided square of two triangles, `half` metres from its centre to its sides, looking up."""
    corners = [(-half, y, -half), (-half, y, half), (half, y, half), (half, y, -half)]
    return Node(
        Mesh(np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]]), material=material, name="floor"),
        name="floor",
    )


def between(low: npt.ArrayLike, high: npt.ArrayLike) -> Solid:
    """The solid between two grids of points, each (n, m, 3), closed around their borders.

    With n points along a curve and m = 2 across a thickness it makes arches and mouldings, with 2 × 2 a box, with n × m
    a vault or a cloth.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    n, m, _ = low.shape
    index = np.arange(n * m).reshape(n, m)
    quads = [_quads(index), _quads(index)[:, ::-1] + n * m]
    border = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    ahead = np.roll(border, -1)
    quads.append(np.stack([border, border + n * m, ahead + n * m, ahead], axis=1))
    # Which grid faces outward depends on how they lie; `outward` settles it for all faces at once.
    return outward(np.concatenate([low.reshape(-1, 3), high.reshape(-1, 3)]), _split(np.concatenate(quads)))


def box(low: VectorLike, high: VectorLike) -> Solid:
    """The axis-aligned box from corner `low` to corner `high`."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    floor, ceiling = ([[(x0, y, z0), (x0, y, z1)], [(x1, y, z0), (x1, y, z1)]] for y in (y0, y1))
    return between(floor, ceiling)


def extrude(inner: npt.ArrayLike, outer: npt.ArrayLike, depth: tuple[float, float]) -> Solid:
    """The strip between two plane curves, each (n, 2) of (x, y), stretched along z over `depth` = (near, far)."""
    inner, outer = np.asarray(inner, np.float64), np.asarray(outer, np.float64)

    def at(z: float) -> Floats:
        return np.stack([np.column_stack([curve, np.full(len(curve), z)]) for curve in (inner, outer)], axis=1)

    return between(at(depth[0]), at(depth[1]))


def panel(
    xs: npt.ArrayLike, ys: npt.ArrayLike, solid: npt.ArrayLike, depth: tuple[float, float], *, lying: bool = False
) -> Solid:
    """A plate with openings: cell (i, j) of the grid lines `xs` × `ys` is filled where `solid[j][i]` is true.

    It stands in the xy plane, or lies in the xz plane with `ys` along z; `depth` is its extent along the third axis.
    One closed surface without T-junctions, so light cannot leak through its seams. No two cells may touch at a corner
    only.
    """
    xs, ys = np.asarray(xs, np.float64), np.asarray(ys, np.float64)
    filled = np.pad(np.asarray(solid, bool).T, 1)
    nx, ny = len(xs), len(ys)
    grid = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    near, far = (np.insert(grid, 1 if lying else 2, at, axis=1) for at in depth)
    index = np.arange(nx * ny).reshape(nx, ny)
    cells = _quads(index)[filled[1:-1, 1:-1].reshape(-1)]
    quads = [cells, cells[:, ::-1] + nx * ny]
    for axis in (0, 1):  # a wall wherever a filled cell meets an open one
        edges_from = index[:, :-1] if axis == 0 else index[:-1, :]
        edges_to = index[:, 1:] if axis == 0 else index[1:, :]
        before = filled[:-1, 1:-1] if axis == 0 else filled[1:-1, :-1]
        after = filled[1:, 1:-1] if axis == 0 else filled[1:-1, 1:]
        a, b = (edges_from, edges_to) if axis == 0 else (edges_to, edges_from)
        for wall, (first, second) in ((after & ~before, (a, b)), (before & ~after, (b, a))):
            f, s = first[wall], second[wall]
            quads.append(np.stack([f, s, s + nx * ny, f + nx * ny], axis=1))
    return outward(np.concatenate([near, far]), _split(np.concatenate(quads)))


def frame(inner: tuple[float, float], outer: tuple[float, float], height: tuple[float, float]) -> Solid:
    """A lying rectangular ring around the y axis: half extents (x, z) inside and outside; `height` (low, high)."""
    xs, zs = ((-far, -near, near, far) for near, far in zip(inner, outer, strict=True))
    return panel(xs, zs, [[1, 1, 1], [1, 0, 1], [1, 1, 1]], height, lying=True)


def lathe(profile: npt.ArrayLike, segments: int = 32, *, flutes: npt.ArrayLike | None = None) -> Solid:
    """The solid of revolution about y of `profile`, (n, 2) of (radius, height) from the bottom pole to the top one.

    End points off the axis are closed by flat caps. `flutes` (n, segments) scales the radius around the axis.
    """
    profile = np.asarray(profile, np.float64)
    if profile[0, 0] > 0.0:
        profile = np.vstack([[0.0, profile[0, 1]], profile])
    if profile[-1, 0] > 0.0:
        profile = np.vstack([profile, [0.0, profile[-1, 1]]])
    angle = np.arange(segments) * (2.0 * np.pi / segments)
    radius = profile[1:-1, :1] * np.ones(segments)
    if flutes is not None:
        radius = radius * np.asarray(flutes, np.float64)
    height = np.broadcast_to(profile[1:-1, 1:], radius.shape)
    rings = np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], axis=-1)
    return _stitch([0.0, profile[0, 1], 0.0], list(rings), [0.0, profile[-1, 1], 0.0])


def sphere(triangles: int = 762, radius: float = 1.0) -> Solid:
    """A sphere at the origin of exactly `triangles` (even, at least 8), nearly equal in size, in rings of latitude.

    762, the spheres of Forest et al. 2006, gives 383 vertices.
    """
    inner = triangles // 2  # Euler: a closed surface of 2n triangles has n + 2 vertices, two of them poles
    rows = max(1, round(0.93 * np.sqrt(np.pi * inner) / 2.0))
    latitude = (np.arange(rows) + 1.0) * np.pi / (rows + 1)
    share = inner * np.sin(latitude) / np.sin(latitude).sum()
    counts = np.maximum(np.floor(share).astype(int), 3)
    by_remainder = np.argsort(-(share - np.floor(share)), kind="stable")
    for ring in np.resize(by_remainder, max(inner - counts.sum(), 0)):
        counts[ring] += 1
    counts[rows // 2] += inner - counts.sum()  # the smallest spheres: rings of three may have taken too many
    rings = []
    for row, (theta, count) in enumerate(zip(latitude, counts, strict=True)):
        angle = (np.arange(count) + 0.5 * (row % 2)) * (2.0 * np.pi / count)
        ring = [np.sin(theta) * np.cos(angle), np.full(count, -np.cos(theta)), np.sin(theta) * np.sin(angle)]
        rings.append(radius * np.stack(ring, axis=1))
    return _stitch([0.0, -radius, 0.0], rings, [0.0, radius, 0.0])


def torus(radius: float, tube: float, segments: int = 48, sides: int = 20) -> Solid:
    """A ring of centre-line `radius` and thickness `tube` (its cross-section's radius), lying in the xz plane."""
    around = (np.arange(segments) * 2.0 * np.pi / segments)[:, None]
    across = np.arange(sides) * 2.0 * np.pi / sides
    reach = radius + tube * np.cos(across)
    grid = np.stack([reach * np.cos(around), tube * np.sin(across) + 0.0 * around, reach * np.sin(around)], axis=-1)
    index = np.pad(np.arange(segments * sides).reshape(segments, sides), ((0, 1), (0, 1)), mode="wrap")
    return outward(grid.reshape(-1, 3), _split(_quads(index)))


def rounded_box(half: VectorLike, radius: float, steps: int = 5) -> Solid:
    """A box of half extents `half` whose edges and corners are rounded by `radius`; `steps` facets per quarter turn."""
    core = np.asarray(half, np.float64) - radius
    angle = np.linspace(0.0, np.pi / 2.0, steps + 1)
    longitude = np.concatenate([angle + quarter * np.pi / 2.0 for quarter in range(4)])
    latitude = np.concatenate([angle - np.pi / 2.0, angle])[:, None]
    corner = np.repeat(np.arange(4), steps + 1)
    side_x, side_z = np.array([1, -1, -1, 1])[corner], np.array([1, 1, -1, -1])[corner]
    side_y = np.repeat([-1, 1], steps + 1)[:, None]
    x = core[0] * side_x + radius * np.cos(latitude) * np.cos(longitude)
    z = core[2] * side_z + radius * np.cos(latitude) * np.sin(longitude)
    y = core[1] * side_y + radius * np.sin(latitude) + 0.0 * longitude
    rings = np.stack([x, y, z], axis=-1)
    bottom, top = [0.0, -half[1], 0.0], [0.0, half[1], 0.0]
    return _stitch(bottom, list(rings), top)


def tube(start: VectorLike, end: VectorLike, radius: float, segments: int = 12) -> Solid:
    """A round bar from `start` to `end` with flat ends."""
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    axis = (b - a) / np.linalg.norm(b - a)
    side = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    angle = (np.arange(segments) * 2.0 * np.pi / segments)[:, None]
    circle = radius * (np.cos(angle) * side + np.sin(angle) * np.cross(axis, side))
    return _stitch(a, [a + circle, b + circle], b)


def _quads(index: npt.NDArray[np.int64]) -> Triangles:
    """(k, 4) vertex numbers of the cells of a grid of vertex numbers."""
    return np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)


def _split(quads: Triangles) -> Triangles:
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _stitch(bottom: npt.ArrayLike, rings: list[Floats], top: npt.ArrayLike) -> Solid:
    """Rings of points, each (n, 3) in the same sense, closed by two poles; neighbours may differ in number."""
    counts = [len(ring) for ring in rings]
    base = np.cumsum([1, *counts])
    first = [(0, base[0] + k, base[0] + (k + 1) % counts[0]) for k in range(counts[0])]
    last = [(base[-1], base[-2] + (k + 1) % counts[-1], base[-2] + k) for k in range(counts[-1])]
    triangles = [np.array(first), np.array(last)]
    triangles += [_band(base[k], counts[k], base[k + 1], counts[k + 1]) for k in range(len(rings) - 1)]
    points = np.concatenate([np.atleast_2d(bottom), *rings, np.atleast_2d(top)])
    return outward(points, np.concatenate(triangles))


def _band(base_a: int, count_a: int, base_b: int, count_b: int) -> Triangles:
    """Triangles between two closed rings: walks both by their fraction of the turn, advancing the one that lags."""
    steps_a, steps_b = np.arange(1, count_a + 1) / count_a, np.arange(1, count_b + 1) / count_b
    order = np.argsort(np.concatenate([steps_a, steps_b]), kind="stable")
    is_a = order < count_a
    a = np.concatenate([[0], np.cumsum(is_a)[:-1]])
    b = np.concatenate([[0], np.cumsum(~is_a)[:-1]])
    here_a, here_b = base_a + a % count_a, base_b + b % count_b
    ahead = np.where(is_a, base_a + (a + 1) % count_a, base_b + (b + 1) % count_b)
    return np.stack([here_a, here_b, ahead], axis=1)
