"""Which meshes are solid, and where flatten() puts their triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
import stage
from softshadows.scene.builtin import shapes
from softshadows.scene.geometry import flatten
from softshadows.scene.solids import is_solid

CUBE = stage.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)).mesh


def mesh(positions: npt.ArrayLike, triangles: npt.ArrayLike, material: ss.Material = stage.MATT) -> ss.Mesh:
    return ss.Mesh(np.array(positions, np.float32), np.array(triangles, np.uint32), material=material)


def cube(triangles: npt.ArrayLike = CUBE.triangles, offset: float = 0.0) -> ss.Mesh:
    """The unit cube, with other triangles or elsewhere."""
    return mesh(CUBE.positions + np.float32(offset), triangles)


def joined(*meshes: ss.Mesh) -> ss.Mesh:
    """Several meshes as one."""
    bases = np.cumsum([0, *(len(m.positions) for m in meshes)])
    triangles = [m.triangles + np.uint32(base) for m, base in zip(meshes, bases, strict=False)]
    return mesh(np.concatenate([m.positions for m in meshes]), np.concatenate(triangles))


def split(whole: ss.Mesh) -> ss.Mesh:
    """Three vertices of its own for every triangle."""
    return mesh(whole.positions[whole.triangles].reshape(-1, 3), np.arange(3 * len(whole.triangles)).reshape(-1, 3))


def flipped(whole: ss.Mesh, count: int | None = None) -> ss.Mesh:
    """The first `count` triangles (None: all) turned around."""
    triangles = whole.triangles.copy()
    triangles[:count] = triangles[:count, ::-1]
    return mesh(whole.positions, triangles)


def with_signed_zeros(whole: ss.Mesh) -> ss.Mesh:
    """As `split`, every second vertex with -0 for 0, which is the same place."""
    result = split(whole)
    odd = result.positions[1::2]
    odd[odd == 0.0] = np.float32(-0.0)
    return result


SPHERE = shapes.mesh(shapes.sphere(762), stage.MATT)
SEAMED = shapes.mesh(shapes.rounded_box((1.0, 0.5, 0.7), 0.2), stage.MATT, crease=10.0)
SLIVER = cube([*CUBE.triangles, (0, 0, 1), (2, 2, 2)])
FIN = mesh([*CUBE.positions, (2.0, 0.0, 0.0)], [*CUBE.triangles, (0, 4, 8)])
SHEET = stage.floor().mesh

SOLID = {
    "cube": cube(),
    "sphere": SPHERE,
    "sphere split at seams": SEAMED,
    "every vertex split": split(SPHERE),
    "signed zeros": with_signed_zeros(cube()),
    "two cubes apart": joined(cube(), cube(offset=3.0)),
    "two cubes that overlap": joined(cube(), cube(offset=0.5)),
    "two cubes that share a corner": joined(cube(), cube(offset=1.0)),
    "degenerate triangles beside": SLIVER,
    "small and far from the origin": mesh(1e-3 * CUBE.positions + np.float32(1000.0), CUBE.triangles),
}
OPEN = {
    "no triangles": cube(np.zeros((0, 3))),
    "degenerate triangles alone": cube([(0, 0, 1), (2, 2, 2)]),
    "one triangle": cube(CUBE.triangles[:1]),
    "open sheet": SHEET,
    "cube with a hole": cube(CUBE.triangles[1:]),
    "cube with a hole that a degenerate triangle fills": cube([*CUBE.triangles[1:], (0, 0, 4)]),
    "one face flipped": flipped(cube(), 1),
    "inward cube": flipped(cube()),
    "an inward cube beside an outward one": joined(cube(), flipped(cube(offset=3.0))),
    "an inward cube at a larger outward one's corner": joined(
        mesh(2.0 * CUBE.positions, CUBE.triangles), flipped(cube(offset=2.0))
    ),
    "a cube and an open sheet": joined(cube(), SHEET),
    "a face twice": cube([*CUBE.triangles, CUBE.triangles[3]]),
    "an edge with three faces": FIN,
    "a sheet and its back": joined(SHEET, flipped(SHEET)),
    "nearly closed": mesh(
        [*(p := CUBE.positions), p[0] + np.float32(1e-6)], [(8, *CUBE.triangles[0][1:]), *CUBE.triangles[1:]]
    ),
}


@pytest.mark.parametrize("name", list(SOLID))
def test_closed_outward_meshes_are_solid(name: str) -> None:
    assert is_solid(SOLID[name])


@pytest.mark.parametrize("name", list(OPEN))
def test_other_meshes_are_not(name: str) -> None:
    assert not is_solid(OPEN[name])


def test_masked_meshes_are_not_solid() -> None:
    assert not is_solid(mesh(CUBE.positions, CUBE.triangles, ss.Material("leaf", alpha_cutoff=0.5)))


def test_the_answer_follows_an_edit_in_place() -> None:
    edited = cube()
    assert is_solid(edited)
    edited.triangles[0] = edited.triangles[0, ::-1].copy()
    assert not is_solid(edited)
    edited.triangles[0] = edited.triangles[0, ::-1].copy()
    assert is_solid(edited)
    edited.positions[7] = edited.positions[6]
    assert is_solid(edited), "a pinched cube is closed still"


def scaled(*diagonal: float) -> npt.NDArray[np.float64]:
    return np.diag([*diagonal, 1.0])


def test_solid_nodes_come_first_then_opaque_then_masked_ones() -> None:
    leaf = mesh(CUBE.positions, CUBE.triangles[:5], ss.Material("leaf", alpha_cutoff=0.5))
    nodes = [ss.Node(leaf), ss.Node(SHEET), ss.Node(cube()), ss.Node(SPHERE), stage.moved(ss.Node(SPHERE), (5, 6, 7))]
    geometry = flatten(ss.Scene(nodes))
    assert geometry.solid_count == 12 + 2 * 762
    assert geometry.opaque_count == geometry.solid_count + 2
    assert len(geometry.triangles) == geometry.opaque_count + 5
    assert geometry.node_starts.tolist() == [0, 12, 774, 1536, 1538, 1543]
    for begin, end, box in zip(geometry.node_starts, geometry.node_starts[1:], geometry.solid_boxes, strict=False):
        corners = geometry.positions[geometry.triangles[begin:end]]
        assert np.array_equal(box, [corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
    assert len(geometry.solid_boxes) == 3


def test_a_scene_without_solids_has_none() -> None:
    geometry = flatten(ss.Scene([ss.Node(SHEET)]))
    assert (geometry.solid_count, geometry.opaque_count, geometry.solid_boxes.shape) == (0, 2, (0, 2, 3))


@pytest.mark.parametrize("transform", [scaled(-1, 1, 1), scaled(-2, -3, -1), scaled(1e-4, 1.0, 1.0)])
def test_a_mirrored_or_stretched_node_stays_solid_and_outward(transform: npt.NDArray[np.float64]) -> None:
    geometry = flatten(ss.Scene([ss.Node(SPHERE, transform)]))
    assert geometry.solid_count == len(SPHERE.triangles)
    assert shapes.signed_volume(geometry.positions, geometry.triangles) > 0.0


@pytest.mark.parametrize("diagonal", [(1.0, 0.0, 1.0), (0.0, 0.0, 0.0), (1e-9, 1.0, 1.0)])
def test_a_flattened_node_is_not_solid(diagonal: tuple[float, float, float]) -> None:
    geometry = flatten(ss.Scene([ss.Node(SPHERE, scaled(*diagonal))]))
    assert (geometry.solid_count, geometry.opaque_count) == (0, len(SPHERE.triangles))


@pytest.mark.parametrize("make", [ss.scenes.sphere_cube, ss.scenes.figures, ss.scenes.atrium, ss.scenes.field])
def test_the_built_in_scenes_are_solid_but_for_their_floors(make: Callable[[], ss.Scene]) -> None:
    geometry = flatten(make())
    assert geometry.solid_count >= len(geometry.triangles) - 2
