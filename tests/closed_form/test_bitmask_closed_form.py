"""`bitmask` against closed forms, in the terms of the project's reliability checks.

Rows run along the light's width, here x, so that an edge along x crosses few of them, and an edge along z all at once.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh

import softshadows as ss
import stage
from softshadows.lights.rows import COLUMNS, SLANT
from softshadows.truth import closed_form

H, h, a, b = 10.0, 4.0, 1.0, 0.6
EDGE, FAR = 0.3, 60.0
ROUNDING = 1.0 / 256.0
LIGHT = ss.RectLight((0.0, H, 0.0), (0.0, 0.0, 0.0), 2.0 * a, 2.0 * b, stage.WHITE)
SIZE = (96, 64)


def under_a_half_plane(light: ss.Light, *, along_x: bool, height: float = h) -> ss.Scene:
    """A floor under a half-plane whose edge runs along x or along z."""
    scene = ss.scenes.blocker(
        light_height=H,
        height=height,
        occluders=[(-FAR, EDGE, -FAR, FAR)],
        turn=-90.0 if along_x else 0.0,
        light=light,
        floor_half=8.0,
    )
    return scene


def from_above(x: float, z: float, width: float = 4.0, eye: float = 0.9 * h) -> ss.Camera:
    """Straight down on (x, z) from below the occluder, a tenth of a degree off: no pixels line up with edges."""
    fov = 2.0 * np.degrees(np.arctan(0.5 * width * SIZE[1] / SIZE[0] / eye))
    return ss.Camera((x, eye, z), (x, 0.0, z), float(fov), up=(np.sin(0.002), 0.0, -np.cos(0.002)))


def largest_error(rows: int, *, along_x: bool) -> float:
    camera = from_above(0.0, 0.5) if along_x else from_above(0.5, 0.0)
    scene = under_a_half_plane(LIGHT, along_x=along_x)
    frame = ss.render(scene, camera, technique=ss.techniques.Bitmask(rows=rows), size=SIZE)
    across = frame.position[..., 2 if along_x else 0].astype(np.float64)
    expected = closed_form.half_plane(across, H, h, b if along_x else a, EDGE)
    assert expected.min() < 0.3
    assert expected.max() > 0.7
    return float(np.abs(frame.visibility[0] - expected).max())


@pytest.mark.parametrize("rows", [4, 8, 16, 32])
def test_an_edge_across_the_rows_errs_by_half_a_column(rows: int) -> None:
    assert largest_error(rows, along_x=False) <= 0.5 / COLUMNS + ROUNDING


def test_an_edge_along_the_rows_errs_by_what_their_slant_leaves_and_by_half_of_that_with_twice_the_rows() -> None:
    errors = [largest_error(rows, along_x=True) for rows in (4, 8, 16, 32)]
    for rows, error in zip((4, 8, 16, 32), errors, strict=True):
        assert error <= (1.0 - SLANT) / (2.0 * rows) + ROUNDING
    for coarse, fine in pairwise(errors):
        assert fine <= 0.5 * coarse + ROUNDING


@pytest.mark.parametrize("height", np.linspace(1.0, 5.0, 9))
@pytest.mark.parametrize("half", [0.25, 0.5, 1.0])
def test_penumbras_are_as_wide_as_they_should_be(height: float, half: float) -> None:
    """From 10 % to 90 % visibility, to a pixel."""
    light = ss.RectLight(LIGHT.position, LIGHT.target, 2.0 * half, 2.0 * half, stage.WHITE)
    width = 2.0 * half * height / (H - height)
    middle = EDGE * H / (H - height)
    camera = from_above(middle, 0.0, 2.0 * width, 0.9 * height)
    frame = ss.render(under_a_half_plane(light, along_x=False, height=height), camera, size=SIZE)
    row = SIZE[1] // 2
    x, visible = frame.position[row, :, 0].astype(np.float64), frame.visibility[0, row]
    ends = [np.interp(share, visible, x) for share in (0.1, 0.9)]
    pixel = 2.0 * width / SIZE[0]
    assert ends[1] - ends[0] == pytest.approx(0.8 * width, abs=pixel + width / COLUMNS)


@pytest.mark.parametrize("degrees", np.linspace(0.0, 85.0, 17))
def test_nothing_shadows_itself(degrees: float) -> None:
    """A plane and a sphere: every sample of the light is seen wherever all of it lies before the surface."""
    angle = np.radians(degrees)
    place = (4.0 * float(np.sin(angle)), 4.0 * float(np.cos(angle)), 0.0)
    light = ss.RectLight(place, (0.0, 0.0, 0.0), 0.3, 0.3, stage.WHITE)
    ball = trimesh.creation.icosphere(3, 0.5)
    sphere = ss.Node(ss.Mesh(np.asarray(ball.vertices, np.float32), np.asarray(ball.faces, np.uint32)))
    for node in (stage.floor(), sphere):
        scene = ss.Scene([node], [light])
        middle, reach = np.mean(scene.bounds(), axis=0), np.ptp(scene.bounds(), axis=0).max()
        camera = ss.Camera(tuple(middle + reach * np.array([0.3, 1.2, 0.9])), tuple(middle), 50.0)
        frame = ss.render(scene, camera, size=SIZE)
        lit = frame.facing[0] & frame.surface
        assert lit.any()
        assert (frame.visibility[0][lit] == 1.0).all()


def test_a_shadow_begins_where_its_box_stands() -> None:
    """A box a metre high, seen from above its shadowed side: a millimetre from the contact nothing is lit."""
    scene = ss.Scene(
        [stage.floor(), stage.box((-1.0, 0.0, -1.0), (0.0, 1.0, 1.0))],
        [ss.RectLight((-4.0, 3.0, 0.0), (0.0, 0.0, 0.0), 0.5, 0.5, stage.WHITE)],
    )
    camera = ss.Camera((0.04, 0.2, 0.0), (0.04, 0.0, 0.0), 18.0, up=(0.0, 0.0, -1.0))
    frame = ss.render(scene, camera, size=SIZE)
    on_floor = frame.surface & (frame.position[..., 1] < 1e-6)
    x = frame.position[..., 0]
    assert x[on_floor].min() < 1e-3
    assert (frame.visibility[0][on_floor] == 0.0).all()


def test_no_light_leaks_into_a_room_of_sheets() -> None:
    """Six sheets without thickness that meet at their edges, the light outside."""
    sheets = [
        stage.floor(1.0),
        stage.floor(1.0, 1.0),
        *(stage.quad([(x, 0.0, -1.0), (x, 1.0, -1.0), (x, 1.0, 1.0), (x, 0.0, 1.0)]) for x in (-1.0, 1.0)),
        *(stage.quad([(-1.0, 0.0, z), (-1.0, 1.0, z), (1.0, 1.0, z), (1.0, 0.0, z)]) for z in (-1.0, 1.0)),
    ]
    camera = ss.Camera((0.0, 0.9, 0.9), (0.0, 0.2, -0.6), 90.0)
    for place in ((0.3, 3.0, 0.2), (3.0, 0.5, 0.1), (2.0, 2.0, 2.0)):
        scene = ss.Scene(sheets, [ss.RectLight(place, (0.0, 0.5, 0.0), 0.5, 0.5, stage.WHITE)])
        frame = ss.render(scene, camera, size=SIZE)
        assert frame.surface.all()
        assert (frame.visibility == 0.0).all()


def test_a_tiny_light_casts_the_hard_shadow_of_rays() -> None:
    """A ten-thousandth of the scene wide: at most a pixel in a thousand lies in a penumbra."""
    scene = stage.standard_scene(ss.RectLight((0.4, 4.0, 0.3), (0.1, 0.0, 0.0), 6e-4, 6e-4, stage.WHITE))
    hard = stage.standard_scene(ss.PointLight((0.4, 4.0, 0.3), stage.WHITE))
    by_rows, by_ray = (ss.render(each, stage.CAMERA, size=SIZE).visibility[0] for each in (scene, hard))
    assert (by_rows == by_ray).mean() >= 0.999
