"""Techniques against the closed forms O1 to O12, in scenes that are those set-ups.

The floor is y = 0, the occluder lies at y = h and the light at y = H: truth/closed_form.py with its z turned upright,
its y the scene's z. The camera looks straight down: every pixel is a receiver of the formula.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
from softshadows.truth import closed_form

H, h, a, b = 10.0, 4.0, 1.0, 0.6
FAR = 60.0
"""Where an occluder ends that stands for a half-plane, metres."""

BAR = {"equal": 0.06, "trapezoid": 0.035}
"""The largest error allowed with 17×17 samples; on O1 equal weights on a closed grid err by 1/17, trapezoid by 1/32."""

Formula = Callable[[npt.NDArray[np.float64], npt.NDArray[np.float64]], npt.NDArray[np.float64]]


def half_plane(edge: float) -> tuple[float, float, float, float]:
    """The blocker X < edge."""
    return (-FAR, edge, -FAR, FAR)


def rect(half_width: float = a, half_height: float = b) -> ss.RectLight:
    return ss.RectLight((0.0, H, 0.0), (0.0, 0.0, 0.0), 2.0 * half_width, 2.0 * half_height, (1.0, 1.0, 1.0))


def line_across() -> ss.LineLight:
    return ss.LineLight((-a, H, 0.0), (a, H, 0.0), (1.0, 1.0, 1.0))


def scene(light: Any, *occluders: tuple[float, float, float, float], height: float = h, turn: float = 0.0) -> ss.Scene:
    return ss.scenes.blocker(light_height=H, height=height, occluders=occluders, turn=turn, light=light, floor_half=8.0)


def disk_occluder(radius: float, sides: int = 256) -> ss.Mesh:
    """A disk about the origin in the plane y = 0; its rim is off by `radius` × 8e-5."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rim = np.stack([radius * np.cos(angle), np.zeros(sides), radius * np.sin(angle)], axis=1)
    corners = np.arange(sides)
    triangles = np.stack([np.full(sides, sides), (corners + 1) % sides, corners], axis=1)
    return ss.Mesh(np.vstack([rim, [[0.0, 0.0, 0.0]]]).astype(np.float32), triangles.astype(np.uint32))


def render(
    made: ss.Scene,
    technique: ss.techniques.Technique,
    *,
    center: tuple[float, float] = (0.5, 0.0),
    width: float = 4.0,
    below: float = h,
    size: tuple[int, int] = (96, 64),
) -> ss.Frame:
    """The floor around `center`, `width` metres of it, seen from just below the occluder, which must not hide it."""
    x, z = center
    eye = 0.9 * below
    fov = 2.0 * np.degrees(np.arctan(0.5 * width * size[1] / size[0] / eye))
    # A tenth of a degree off, so that pixels do not line up with the occluder's edges.
    camera = ss.Camera((x, eye, z), (x, 0.0, z), float(fov), up=(np.sin(0.002), 0.0, -np.cos(0.002)))
    frame = ss.render(made, camera, technique=technique, size=size)
    assert frame.surface.all()
    assert np.abs(frame.position[..., 1]).max() < 1e-5
    assert frame.facing.all()
    return frame


def check(frame: ss.Frame, formula: Formula, limit: float, compare: Any, texels: float = 0.0) -> None:
    """The frame equals the formula to `limit` everywhere; `texels` metres about a step are left out."""
    x, z = frame.position[..., 0].astype(np.float64), frame.position[..., 2].astype(np.float64)
    expected = formula(x, z)
    assert expected.min() < 0.3, "the picture shows no shadow"
    assert expected.max() > 0.7, "the picture shows no light"
    near_step = np.zeros(x.shape, bool)
    if texels:
        near_step = formula(x - texels, z) != formula(x + texels, z)
        assert near_step.mean() < 0.1
    compare(frame.visibility[0], expected, limit=limit, mask=~near_step)


def uniform(weights: str = "trapezoid", **options: Any) -> ss.techniques.Technique:
    return ss.techniques.Uniform(**{"weights": weights, "resolution": 512, **options})


both_weights = pytest.mark.parametrize("weights", list(BAR))


# -- The closed forms with uniform light sampling ----------------------------------------------------------------------


@both_weights
def test_o1_half_plane_parallel_to_the_light(weights: str, compare_visibility: Any) -> None:
    frame = render(scene(rect(), half_plane(0.3)), uniform(weights))
    check(frame, lambda x, z: closed_form.half_plane(x, H, h, a, 0.3), BAR[weights], compare_visibility)


@both_weights
def test_o2_half_plane_at_an_angle(weights: str, compare_visibility: Any) -> None:
    """The scene's `turn` is about y, from x towards −z: by −θ in the formula's plane, where y is z."""
    frame = render(scene(rect(), half_plane(0.3), turn=-35.0), uniform(weights))
    check(
        frame,
        lambda x, z: closed_form.rotated_half_plane(x, z, H, h, a, b, 35.0, 0.3),
        BAR[weights],
        compare_visibility,
    )


def test_o3_half_plane_under_a_disk(compare_visibility: Any) -> None:
    light = ss.DiskLight((0.0, H, 0.0), (0.0, 0.0, 0.0), a, (1.0, 1.0, 1.0))
    frame = render(scene(light, half_plane(0.3)), uniform())
    check(frame, lambda x, z: closed_form.half_plane_disk(x, H, h, a, 0.3), BAR["trapezoid"], compare_visibility)


@both_weights
def test_o4_rectangle(weights: str, compare_visibility: Any) -> None:
    """Where edges along both axes cross the light, their errors add up: to 1 − (1 − e)² at an umbra's corner."""
    x0, x1, z0, z1 = card = (-0.8, 0.5, -0.45, 0.9)
    frame = render(scene(rect(), card), uniform(weights), center=(0.0, 0.2), width=6.0)
    x, z = frame.position[..., 0].astype(np.float64), frame.position[..., 2].astype(np.float64)
    expected = closed_form.rectangle(x, z, H, h, a, b, card)
    across = closed_form.strip(x - (x0 + x1) / 2 * H / (H - h), H, h, a, (x1 - x0) / 2)
    along = closed_form.strip(z - (z0 + z1) / 2 * H / (H - h), H, h, b, (z1 - z0) / 2)
    corner = (across > 0.0) & (across < 1.0) & (along > 0.0) & (along < 1.0)
    compare_visibility(frame.visibility[0], expected, limit=BAR[weights], mask=~corner)
    compare_visibility(frame.visibility[0], expected, limit=1.0 - (1.0 - BAR[weights]) ** 2, mask=corner)


@both_weights
def test_o5_two_rectangles(weights: str, compare_visibility: Any) -> None:
    """Overlapping at two heights: up to four edges cross the light, and the errors of some of them can add up."""
    lower, upper = (-0.8, 0.5, -0.45, 0.9), (0.1, 1.1, -0.9, 0.3)
    made = scene(rect(), lower)
    made.nodes += scene(rect(), upper, height=6.0).nodes[1:]
    frame = render(made, uniform(weights), center=(-0.2, 0.2), width=6.0)
    check(
        frame,
        lambda x, z: closed_form.two_rectangles(x, z, H, a, b, (h, lower), (6.0, upper)),
        3.0 * BAR[weights],
        compare_visibility,
    )
    x, z = frame.position[..., 0].astype(np.float64), frame.position[..., 2].astype(np.float64)
    expected = closed_form.two_rectangles(x, z, H, a, b, (h, lower), (6.0, upper))
    compare_visibility(frame.visibility[0], expected, limit=BAR[weights], share=0.05)


def test_o6_disk_under_a_disk(compare_visibility: Any) -> None:
    light = ss.DiskLight((0.0, H, 0.0), (0.0, 0.0, 0.0), a, (1.0, 1.0, 1.0))
    made = scene(light)
    raised = np.eye(4)
    raised[1, 3] = h
    made.nodes.append(ss.Node(disk_occluder(0.5), raised))
    frame = render(made, uniform(), center=(0.1, 0.0), width=4.5)
    check(frame, lambda x, z: closed_form.disk(np.hypot(x, z), H, h, a, 0.5), BAR["trapezoid"], compare_visibility)


def test_o7_edge_parallel_to_a_line_is_a_step(compare_visibility: Any) -> None:
    """No penumbra: nothing between 0 and 1 but within a texel of the edge."""
    light = ss.LineLight((0.2, H, -b), (0.2, H, b), (1.0, 1.0, 1.0))
    frame = render(scene(light, half_plane(0.3)), uniform())
    check(
        frame,
        lambda x, z: closed_form.parallel_edge(x, H, h, 0.3, line=0.2),
        1e-6,
        compare_visibility,
        texels=2.0 * 4.0 / 512,
    )


@both_weights
@pytest.mark.parametrize("oracle", ["O9 strip", "O10 slit"])
def test_o9_o10_what_neither_end_of_a_line_sees(oracle: str, weights: str, compare_visibility: Any) -> None:
    strip = oracle == "O9 strip"
    occluders = [(-0.2, 0.2, -FAR, FAR)] if strip else [half_plane(-0.2), (0.2, FAR, -FAR, FAR)]
    formula = closed_form.strip if strip else closed_form.slit
    frame = render(scene(line_across(), *occluders), uniform(weights), center=(0.3, 0.0))
    x = frame.position[..., 0].astype(np.float64)
    # Two edges cross the light: the error of both adds up.
    compare_visibility(frame.visibility[0], formula(x, H, h, a, 0.2), limit=2.0 * BAR[weights])
    middle = np.abs(x) < 0.02
    assert np.abs(frame.visibility[0][middle] - 0.5).max() < BAR[weights]


@both_weights
def test_o8_tilted_receiver_under_a_line(weights: str, compare_visibility: Any) -> None:
    """A hyperbola, not a ramp: the floor leans against the light by `slope`."""
    slope, drop = 0.5, 4.0  # the receiver, as seen from the edge at the origin: y = slope x − drop
    light_height = 6.0
    light = ss.LineLight((-a, light_height, 0.0), (a, light_height, 0.0), (1.0, 1.0, 1.0))
    edge = ss.Mesh(
        np.float32([(-FAR, 0, -FAR), (-FAR, 0, FAR), (0, 0, FAR), (0, 0, -FAR)]), np.uint32([[0, 1, 2], [0, 2, 3]])
    )
    floor = ss.Mesh(
        np.float32([(x, slope * x - drop, z) for x, z in ((-6, -6), (-6, 6), (6, 6), (6, -6))]),
        np.uint32([[0, 1, 2], [0, 2, 3]]),
    )
    made = ss.Scene([ss.Node(edge), ss.Node(floor)], [light])
    camera = ss.Camera((0.3, -0.5, 0.1), (0.0, -drop, 0.0), 50.0, up=(0.0, 0.0, -1.0))
    frame = ss.render(made, camera, technique=uniform(weights), size=(96, 64))
    assert frame.facing.all()
    check(
        frame,
        lambda x, z: closed_form.tilted_receiver(x, 0.0, light_height, slope, -drop, -a, a),
        BAR[weights],
        compare_visibility,
    )


def test_o11_contact_has_no_penumbra(compare_visibility: Any) -> None:
    """A wall that stands on the floor: at its foot the shadow is a step."""
    wall = ss.Mesh(
        np.float32([(0, 0, -FAR), (0, 0, FAR), (0, 3, FAR), (0, 3, -FAR)]),
        np.uint32([[0, 1, 2], [0, 2, 3]]),
        material=ss.Material(double_sided=True),
    )
    light = ss.RectLight((6.0, 8.0, 0.0), (0.0, 0.0, 0.0), 1.0, 1.0, (1.0, 1.0, 1.0))
    made = scene(light)
    made.nodes.append(ss.Node(wall))
    camera = ss.Camera((0.0, 2.0, 0.0), (0.0, 0.0, 0.0), 30.0, up=(np.sin(0.002), 0.0, -np.cos(0.002)))
    frame = ss.render(made, camera, technique=uniform(), size=(96, 64))
    x = frame.position[..., 0]
    floor = frame.position[..., 1] < 1e-5
    expected = closed_form.contact(x, 0.0)
    apart = floor & (np.abs(x) > 0.01)
    compare_visibility(frame.visibility[0], expected, limit=1e-6, mask=apart)


def test_o12_light_of_no_size_casts_a_hard_shadow(compare_visibility: Any) -> None:
    frame = render(scene(rect(0.0, 0.0), half_plane(0.3)), uniform())
    assert set(np.unique(frame.visibility)) == {0.0, 1.0}
    check(
        frame,
        lambda x, z: closed_form.hard_shadow(x, H, h, 0.3),
        1e-6,
        compare_visibility,
        texels=2.0 * 4.0 / 512,
    )


# -- Convergence and widths --------------------------------------------------------------------------------------------


def o1_error(weights: str, grid: int) -> npt.NDArray[np.float64]:
    """Errors inside the penumbra of O1 under a line, where `grid` samples cost `grid` maps."""
    frame = render(
        scene(line_across(), half_plane(0.3)), uniform(weights, grid=grid, resolution=1024), width=1.5, size=(640, 4)
    )
    expected = closed_form.half_plane(frame.position[..., 0], H, h, a, 0.3)
    inside = (expected > 0.0) & (expected < 1.0)
    return (frame.visibility[0] - expected)[inside]


@pytest.mark.parametrize(("weights", "largest", "rms"), [("equal", 1 / 17, 0.0248), ("trapezoid", 1 / 32, 0.0180)])
def test_error_on_o1_is_the_papers(weights: str, largest: float, rms: float) -> None:
    """With 17 samples: the figures of a simulation in float64, which is the light sampling's error alone."""
    error = o1_error(weights, 17)
    assert np.abs(error).max() == pytest.approx(largest, rel=0.06)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(rms, rel=0.06)


def test_twice_the_samples_halve_the_error() -> None:
    """R10: depths 2, 3 and 4 of the paper, 5, 9 and 17 samples along the light."""
    rms = [np.sqrt(np.mean(o1_error("equal", grid) ** 2)) for grid in (5, 9, 17)]
    for coarse, fine in pairwise(rms):
        assert fine / coarse == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize("height", [1.0, 2.5, 4.0, 6.0])
def test_pcss_penumbra_width_on_o1(height: float) -> None:
    """Its grid is a box kernel with the light's shape, which reproduces O1: the 10–90 % width is right to 10 %."""
    exact = 2.0 * a * height / (H - height)
    middle = 0.3 * H / (H - height)  # where the light's centre meets the edge
    frame = render(
        scene(rect(), half_plane(0.3), height=height),
        ss.techniques.Pcss(resolution=1024),
        center=(middle, 0.0),
        width=4.0 * exact,
        below=height,
        size=(160, 120),
    )
    middle_of_picture = slice(40, -40)
    x = frame.position[60, middle_of_picture, 0]
    width = ss.metrics.penumbra_width(frame.visibility[0][60, middle_of_picture], float(np.diff(x).mean()))
    assert width / 0.8 == pytest.approx(exact, rel=0.1)
