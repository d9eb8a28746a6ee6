"""What a light's shape answers, against points of it; and lights made of others: a polygon's sides in its place."""

from __future__ import annotations

import numpy as np
import pytest

import softshadows as ss
from softshadows.lights.grid import grid_samples
from softshadows.scene.lights import LIGHT_CLASSES, Light

WHITE = (1.0, 1.0, 1.0)
LIGHTS: dict[str, Light] = {
    light.kind: light
    for light in (
        ss.RectLight((1.0, 2.0, 3.0), (0.2, -0.7, 0.4), 1.0, 2.5, WHITE),
        ss.DiskLight((1.0, 2.0, 3.0), (0.2, -0.7, 0.4), 0.8, WHITE),
        ss.LineLight((1.0, 2.0, 3.0), (0.2, -0.7, 0.4), WHITE),
        ss.PointLight((1.0, 2.0, 3.0), WHITE),
        ss.SpotLight((1.0, 2.0, 3.0), (0.2, -0.7, 0.4), WHITE),
        ss.DirectionalLight((0.3, -1.0, 0.2), WHITE),
    )
}
every_light = pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)


def test_every_class_is_here() -> None:
    assert list(LIGHTS) == list(LIGHT_CLASSES)


@every_light
def test_a_moved_light_is_the_light_elsewhere(light: Light) -> None:
    moved = light.moved((0.5, -1.0, 2.0))
    assert moved.half_extent == pytest.approx(light.half_extent)
    if light.is_directional:
        assert moved.axes[2] @ light.axes[2] < 0.99, "it turns"
        assert np.isfinite(moved.axes).all()
    else:
        np.testing.assert_allclose(moved.center, np.add(light.center, (0.5, -1.0, 2.0)))
        np.testing.assert_allclose(moved.axes, light.axes, atol=1e-12)


@every_light
def test_the_smallest_move_makes_another_light(light: Light) -> None:
    assert light.moved((1e-6, 0.0, 0.0)) != light


def outline(light: Light) -> np.ndarray:
    """(n, 3): points on the light's border, world space."""
    t = np.linspace(0.0, 1.0, 401)
    zero, one = np.zeros_like(t), np.ones_like(t)
    return light.points(np.concatenate([t, t, zero, one]), np.concatenate([zero, one, t, t]))


@every_light
def test_the_reach_is_that_of_the_farthest_point(light: Light) -> None:
    directions = np.random.default_rng(5).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    farthest = ((outline(light) - light.center) @ directions.T).max(axis=0)
    np.testing.assert_allclose(light.reach(directions), farthest, rtol=1e-4, atol=1e-12)


@every_light
def test_facing_says_whether_every_point_is_before_the_receiver(light: Light) -> None:
    random = np.random.default_rng(7)
    position = light.center + random.normal(size=(400, 3)) * 2.0
    normal = random.normal(size=(400, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    if light.is_directional:
        before = normal @ light.axes[2] > 0.0
    else:
        before = (np.einsum("pi,qpi->qp", normal, outline(light)[:, None] - position) > 0.0).all(axis=0)
        if light.one_sided:
            before &= (light.center - position) @ light.axes[2] > 0.0
    facing = light.facing(position, normal)
    assert 20 < facing.sum() < 380
    assert np.count_nonzero(facing != before) <= 1, "at most one receiver whose plane touches the light"


@every_light
def test_without_size_it_is_a_point_at_the_same_place(light: Light) -> None:
    point = light.without_size
    assert not point.has_size
    assert not point.is_flat
    assert light.has_size == (light.kind in ("rect", "disk", "line"))
    np.testing.assert_allclose(point.center, light.center)
    assert point.one_sided == light.one_sided


CORNERS = [(0.0, 2.0, 0.0), (3.0, 2.0, 0.0), (0.0, 2.0, 4.0)]


def test_an_outline_is_the_sides_and_shines_as_brightly() -> None:
    sides = ss.LineLight.outline(CORNERS, (10.0, 5.0, 0.0))
    assert [(side.start, side.end) for side in sides] == list(zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True))
    lengths = [2.0 * side.half_extent[0] for side in sides]
    assert sum(lengths) == pytest.approx(3.0 + 4.0 + 5.0)
    together = np.array([side.radiance for side in sides]).T @ lengths
    assert together == pytest.approx(6.0 * np.array([10.0, 5.0, 0.0])), "W/sr along the normal: radiance times area"


@pytest.mark.parametrize(
    "corners", [[], CORNERS[:2], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)], [*CORNERS[:2], (0.0, 1.0)]]
)
def test_an_outline_needs_an_area(corners: list) -> None:
    with pytest.raises(ss.errors.SceneError, match="corners"):
        ss.LineLight.outline(corners, (1.0, 1.0, 1.0))


@pytest.mark.parametrize("kind", ["rect", "disk"])
def test_samples_do_not_depend_on_where_the_light_is(kind: str) -> None:
    """A grid's points are computed in light space, so that no rounding of world coordinates reaches them."""
    points, weights = grid_samples(LIGHTS[kind], 5, "trapezoid")
    far, _ = grid_samples(LIGHTS[kind].moved((4e6, 0.0, -7e5)), 5, "trapezoid")
    np.testing.assert_array_equal(points, far)
    np.testing.assert_allclose(weights @ points, 0.0, atol=1e-12)
    assert np.abs(points).max() == pytest.approx(max(LIGHTS[kind].half_extent))
