"""The light and the view that a scene without them is given."""

from __future__ import annotations

import numpy as np
import pytest

import softshadows as ss
from softshadows.scene.builtin.shapes import box, mesh
from softshadows.scene.framing import ceiling_light, complete, framing_camera

CORNERS = ((-2.0, 0.0, -3.0), (2.0, 2.5, 3.0))
INSIDE = ss.Camera(position=(0.5, 1.2, 2.5), target=(0.0, 1.0, -3.0))


def room() -> ss.Scene:
    return ss.Scene([ss.Node(mesh(box(*CORNERS), ss.Material()))])


def test_a_closed_room_is_lit_from_below_its_ceiling() -> None:
    scene = room()
    scene.camera = INSIDE
    notes = complete(scene)
    light = scene.lights[0]
    assert isinstance(light, ss.RectLight)
    assert ((np.array(light.position) > CORNERS[0]) & (np.array(light.position) < CORNERS[1])).all()
    assert light.position[1] == pytest.approx(2.38, abs=0.03)
    assert light.target[1] == pytest.approx(0.0, abs=1e-6)
    assert any("below the ceiling" in note for note in notes)


def test_without_a_ceiling_in_view_the_light_stands_above_the_scene() -> None:
    scene = room()
    assert ceiling_light(scene, framing_camera(scene)) is None
    notes = complete(scene)
    assert scene.lights[0].center[1] > CORNERS[1][1]
    assert any("above the scene" in note for note in notes)


def test_the_view_is_as_close_as_the_vertices_allow() -> None:
    """A disk leaves the corners of its box empty: the camera stands nearer to it than to its square."""
    angles = np.linspace(0.0, 2.0 * np.pi, 64)
    ring = np.stack([np.cos(angles), np.zeros(64), np.sin(angles)], axis=1)
    triangles = np.stack([np.zeros(62), np.arange(1, 63), np.arange(2, 64)], axis=1)
    disk = ss.Scene([ss.Node(ss.Mesh(ring, triangles.astype(np.uint32)))])
    square = ss.Scene([ss.Node(ss.Mesh(np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1]]), np.array([[0, 1, 2]])))])
    near, far = (np.linalg.norm(framing_camera(scene).position) for scene in (disk, square))
    assert near < far
