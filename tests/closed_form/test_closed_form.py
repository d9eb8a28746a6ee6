"""Each closed form against brute force: the light cut into many points, each joined to the receiver by itself."""

from __future__ import annotations

import numpy as np
import pytest

from softshadows.truth import closed_form

H, h, a, b = 10.0, 4.0, 1.0, 0.6
X = np.linspace(-2.5, 2.5, 101)


def light_line(count: int = 20000) -> np.ndarray:
    return a * ((2 * np.arange(count) + 1) / count - 1)


def light_rectangle(count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    middle = (2 * np.arange(count) + 1) / count - 1
    u, v = np.meshgrid(a * middle, b * middle)
    return u.ravel(), v.ravel()


def light_disk(radius: float, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    middle = (2 * np.arange(count) + 1) / count - 1
    u, v = (radius * grid.ravel() for grid in np.meshgrid(middle, middle))
    inside = u * u + v * v < radius * radius
    return u[inside], v[inside]


def crossing(x: float, u: np.ndarray, height: float = h) -> np.ndarray:
    """Where the segment from (x, 0) to (u, H) passes `height`: independent of the projection that the oracles use."""
    return x + (u - x) * height / H


def test_o1_half_plane_against_sampling_and_the_worked_example() -> None:
    sampled = [np.mean(crossing(x, light_line()) >= 0.3) for x in X]
    np.testing.assert_allclose(closed_form.half_plane(X, H, h, a, 0.3), sampled, atol=1e-4)
    ends = closed_form.half_plane([-1 / 6, 0.5, 7 / 6], H, h, a, 0.3)
    np.testing.assert_allclose(ends, [0.0, 0.5, 1.0], atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-8, 30.0, 45.0, 60.0, 90.0, 135.0, 200.0])
def test_o2_rotated_half_plane_against_sampling(angle: float) -> None:
    u, v = light_rectangle()
    y, cos, sin = 0.2, np.cos(np.radians(angle)), np.sin(np.radians(angle))
    sampled = [np.mean(crossing(x, u) * cos + crossing(y, v) * sin >= 0.1) for x in X]
    np.testing.assert_allclose(closed_form.rotated_half_plane(X, y, H, h, a, b, angle, 0.1), sampled, atol=2.6e-3)


def test_o2_without_rotation_is_o1() -> None:
    expected = closed_form.half_plane(X, H, h, a, 0.3)
    np.testing.assert_allclose(closed_form.rotated_half_plane(X, 0.7, H, h, a, b, 0.0, 0.3), expected, atol=1e-12)
    np.testing.assert_allclose(closed_form.rotated_half_plane(X, 0.0, H, h, a, b, 1e-5, 0.3), expected, atol=1e-6)


def test_o3_half_plane_disk_against_sampling() -> None:
    u, _ = light_disk(a)
    sampled = [np.mean(crossing(x, u) >= 0.3) for x in X]
    np.testing.assert_allclose(closed_form.half_plane_disk(X, H, h, a, 0.3), sampled, atol=4e-3)


def blocked_by_rectangle(x: float, y: float, u: np.ndarray, v: np.ndarray, height: float, box: tuple) -> np.ndarray:
    p, q = crossing(x, u, height), crossing(y, v, height)
    return (p > box[0]) & (p < box[1]) & (q > box[2]) & (q < box[3])


def test_o4_rectangle_against_sampling() -> None:
    u, v = light_rectangle()
    box = (-0.3, 0.5, -0.2, 0.35)
    sampled = [1.0 - np.mean(blocked_by_rectangle(x, 0.15, u, v, h, box)) for x in X]
    np.testing.assert_allclose(closed_form.rectangle(X, 0.15, H, h, a, b, box), sampled, atol=2.6e-3)


@pytest.mark.parametrize(
    "second",
    [(h, (1.2, 1.6, -0.2, 0.2)), (h, (-0.1, 0.1, -0.1, 0.1)), (6.0, (0.2, 0.8, -0.1, 0.5))],
    ids=["disjoint", "nested", "crossing at another height"],
)
def test_o5_two_rectangles_against_sampling(second: tuple) -> None:
    u, v = light_rectangle()
    first = (h, (-0.3, 0.5, -0.2, 0.35))
    sampled = [
        1.0 - np.mean(blocked_by_rectangle(x, 0.1, u, v, *first) | blocked_by_rectangle(x, 0.1, u, v, *second))
        for x in X
    ]
    np.testing.assert_allclose(closed_form.two_rectangles(X, 0.1, H, a, b, first, second), sampled, atol=5e-3)


def test_o6_disk_against_sampling_and_the_worked_example() -> None:
    u, v = light_disk(1.0)
    for radius in (0.1, 0.5, 0.9):
        sampled = [1.0 - np.mean(np.hypot(crossing(x, u), crossing(0.0, v)) < radius) for x in X]
        np.testing.assert_allclose(closed_form.disk(X, H, h, 1.0, radius), sampled, atol=4e-3)
    shadowed = 1.0 - closed_form.disk([0.0, 0.5, 1.0, 1.5], H, h, 1.0, 0.5)
    np.testing.assert_allclose(shadowed, [1.0, 0.7225, 0.2745, 0.0], atol=5e-5)


def test_circles_overlap_at_its_limits() -> None:
    assert closed_form.circles_overlap(1.0, 1.0, 0.0) == pytest.approx(np.pi)
    assert closed_form.circles_overlap(1.0, 0.25, 0.75) == pytest.approx(np.pi / 16)
    assert closed_form.circles_overlap(1.0, 0.5, 1.5) == 0.0
    assert closed_form.circles_overlap(1.0, 1.0, 1.0) == pytest.approx(2 * np.pi / 3 - np.sqrt(3) / 2)


def test_o7_parallel_edge_is_a_step() -> None:
    sampled = [float(crossing(x, np.array([0.25]))[0] >= 0.3) for x in X]
    np.testing.assert_array_equal(closed_form.parallel_edge(X, H, h, 0.3, line=0.25), sampled)


def test_o8_tilted_receiver_against_sampling() -> None:
    m, t, n, s = 0.15, 3.0, 0.3, -2.0
    light_x = light_line()
    light_y = m * light_x + t
    sampled = []
    for x2 in X:
        y2 = n * x2 + s
        sampled.append(np.mean(x2 + (light_x - x2) * -y2 / (light_y - y2) >= 0.0))
    np.testing.assert_allclose(closed_form.tilted_receiver(X, m, t, n, s, -a, a), sampled, atol=1e-4)


@pytest.mark.parametrize(("slope", "expected"), [(0.0, 0.0), (0.3, None)])
def test_o8_departs_from_a_ramp_as_predicted(slope: float, expected: float | None) -> None:
    m, t, s = 0.0, 3.0, -2.0

    def receiver_of(x1: float) -> float:
        return x1 * s / (t - (slope - m) * x1)

    ends = receiver_of(a), receiver_of(-a)
    x2 = np.linspace(*ends, 20001)
    ramp = np.linspace(0.0, 1.0, 20001)
    found = np.abs(closed_form.tilted_receiver(x2, m, t, slope, s, -a, a) - ramp).max()
    ratio = ((slope - m) * ends[0] + s) / ((slope - m) * ends[1] + s)
    predicted = closed_form.tilted_receiver_deviation(ratio)
    assert found == pytest.approx(float(predicted), abs=1e-6)
    if expected is not None:
        assert found == pytest.approx(expected, abs=1e-12)


def test_o8_deviation_of_the_worked_examples() -> None:
    found = closed_form.tilted_receiver_deviation([1.128, 0.818, 1.381])
    np.testing.assert_allclose(found, [0.030, 0.050, 0.081], atol=5e-4)


def test_o9_strip_against_sampling_and_where_both_ends_are_seen() -> None:
    sampled = [np.mean(np.abs(crossing(x, light_line())) >= 0.2) for x in X]
    np.testing.assert_allclose(closed_form.strip(X, H, h, a, 0.2), sampled, atol=2e-4)
    assert closed_form.strip(0.0, H, h, a, 0.2) == pytest.approx(0.5)


def test_o10_slit_against_sampling_and_where_no_end_is_seen() -> None:
    sampled = [np.mean(np.abs(crossing(x, light_line())) < 0.2) for x in X]
    np.testing.assert_allclose(closed_form.slit(X, H, h, a, 0.2), sampled, atol=2e-4)
    assert closed_form.slit(0.0, H, h, a, 0.2) == pytest.approx(0.2 * H / (a * h))


def test_o11_contact_is_the_limit_of_o1() -> None:
    np.testing.assert_array_equal(closed_form.contact(X, 0.31), closed_form.half_plane(X, H, 1e-9, a, 0.31).round())


def test_o12_is_the_limit_of_o1_for_a_vanishing_light() -> None:
    np.testing.assert_array_equal(closed_form.hard_shadow(X, H, h, 0.31), closed_form.half_plane(X, H, h, 1e-12, 0.31))
