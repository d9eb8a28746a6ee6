"""Edges and objects of meshes, closed or not (`scene/edges.py`)."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import softshadows as ss
import stage
from softshadows.scene.builtin import shapes
from softshadows.scene.edges import MeshEdges, edges_of


def edges(positions: Any, triangles: Any) -> MeshEdges:
    return edges_of(ss.Mesh(np.array(positions, np.float32), np.array(triangles, np.uint32)))


def check(found: MeshEdges, triangles: np.ndarray) -> None:
    """Triangles name edges that join their corners, and edges name those triangles, with the right direction."""
    for k in range(3):
        start, end = triangles[found.order, k], triangles[found.order, (k + 1) % 3]
        own = found.triangle_edges[:, k]
        assert (np.sort(np.stack([start, end], axis=1), axis=1) == found.vertices[own]).all()
        is_own = found.triangles[own] == found.order[:, None]
        assert (is_own.sum(axis=1) == 1).all()
        assert ((found.is_forward[own] == (start < end)[:, None]) | ~is_own).all()
    assert found.edge_starts[-1] == len(found.vertices)
    assert found.triangle_starts[-1] == len(found.order)


def test_a_closed_surface_has_two_triangles_at_every_edge() -> None:
    mesh = shapes.mesh(shapes.sphere(762, 1.0), stage.MATT)
    found = edges_of(mesh)
    check(found, mesh.triangles.astype(np.int64))
    assert len(found.vertices) == 762 * 3 // 2
    assert (found.triangles >= 0).all()
    assert (found.is_forward[:, 0] != found.is_forward[:, 1]).all()
    assert found.is_closed.tolist() == [True]
    assert found.is_card.tolist() == [False]


def test_a_card_is_open_and_flat() -> None:
    mesh = stage.floor().mesh
    found = edges_of(mesh)
    check(found, mesh.triangles.astype(np.int64))
    assert (found.triangles[:, 1] < 0).sum() == 4
    assert not found.is_closed[0]
    assert found.is_card[0]


def test_objects_are_what_is_connected() -> None:
    """Three boxes in one mesh, their vertices not shared between faces, in an order that mixes them."""
    boxes = [stage.box((2.0 * i, 0.0, 0.0), (2.0 * i + 1.0, 1.0, 1.0)).mesh for i in range(3)]
    positions = np.concatenate([box.positions[box.triangles].reshape(-1, 3) for box in boxes])
    triangles = np.arange(len(positions)).reshape(-1, 3)
    found = edges(positions, np.random.default_rng(1).permutation(triangles))
    assert found.is_closed.tolist() == [True] * 3
    assert np.diff(found.edge_starts).tolist() == [18] * 3
    assert np.diff(found.triangle_starts).tolist() == [12] * 3


BOX = stage.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)).mesh


def test_a_flipped_face_leaves_a_surface_closed_and_a_missing_one_does_not() -> None:
    faces = BOX.triangles
    assert edges(BOX.positions, np.vstack([faces[:1, ::-1], faces[1:]])).is_closed.all()
    assert not edges(BOX.positions, faces[1:]).is_closed.any()


def test_doubled_triangles_are_one() -> None:
    found = edges(BOX.positions, np.vstack([BOX.triangles, BOX.triangles[:2], BOX.triangles[4:5, ::-1]]))
    assert found.is_closed.all()
    assert sorted(found.order.tolist()) == list(range(12))


def test_an_edge_of_three_triangles_is_three_edges() -> None:
    found = edges([(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0)], [(0, 1, 2), (0, 1, 3), (0, 1, 4)])
    shared = (found.vertices == [0, 1]).all(axis=1)
    assert shared.sum() == 3
    assert sorted(found.triangles[shared, 0].tolist()) == [0, 1, 2]
    assert (found.triangles[:, 1] == -1).all()
    assert len(found.is_closed) == 1


def test_slivers_and_points_do_not_open_a_surface() -> None:
    middle = BOX.positions[BOX.triangles[0, :2]].mean(axis=0, keepdims=True)
    a, b, _ = BOX.triangles[0]
    found = edges(np.vstack([BOX.positions, middle]), np.vstack([BOX.triangles, [(a, a, b), (a, 8, b)]]))
    assert found.is_closed.all()
    assert len(found.order) == 12


def test_a_sliver_that_closes_a_seam_stays() -> None:
    """A side of a box is split at a vertex that the next face does not have; a triangle without area fills the gap."""
    a, b, c = (int(index) for index in BOX.triangles[0])
    middle = BOX.positions[[a, b]].mean(axis=0, keepdims=True)
    split = [(a, 8, c), (8, b, c), (a, b, 8)]
    found = edges(np.vstack([BOX.positions, middle]), np.vstack([split, BOX.triangles[1:]]))
    assert found.is_closed.all()
    assert len(found.order) == 14


def test_parts_across_a_t_junction_are_one_object() -> None:
    points = [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1), (0, 0, 1), (-1, 0, 2), (1, 0, 2)]
    found = edges(points, [(0, 2, 1), (0, 3, 2), (3, 5, 4), (4, 5, 6), (4, 6, 2)])
    assert found.is_card.tolist() == [True]


def test_nothing_has_no_edges() -> None:
    found = edges(np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(found.vertices) == len(found.order) == len(found.is_closed) == 0


def test_a_million_triangles_in_the_time_of_ten_sorts() -> None:
    """Three seconds of a core of one's own. Sorting a mesh's 3 million sides is slowed down alike by whatever else runs
    on the machine, which seconds are not: six to eight sorts are measured, alone and among four.
    """
    sphere = shapes.sphere(1_000_000, 1.0)
    sides = np.random.default_rng(0).integers(0, 1 << 40, 3_000_000)

    def seconds(work: Callable[[], object]) -> float:
        started = time.process_time()
        work()
        return time.process_time() - started

    def sorts() -> float:
        mesh = ss.Mesh(sphere.positions.astype(np.float32), sphere.triangles.astype(np.uint32))
        sort = seconds(lambda: np.argsort(sides, kind="stable"))
        found = seconds(lambda: edges_of(mesh))
        assert edges_of(mesh).is_closed.all()
        return found / sort

    assert any(sorts() <= 10.0 for _ in range(3))
