"""The maths of Occluding Edges Soft Shadows in flatland: what is exact, and how far off the paper says it is."""

from __future__ import annotations

import numpy as np
import pytest

import occluding_edges_model as model
from occluding_edges_model import Card, Circle, Flatland
from softshadows.truth import closed_form

H, h, a = 10.0, 4.0, 1.0
"""The light's height above the floor, the occluder's, and half the light's length, metres."""
FAR = 60.0


def triangles(count: int = 2000) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Left and right end, fragment, an edge before it, and the share of the light left of the line through both."""
    random = np.random.default_rng(3)
    left = np.zeros((count, 2))
    right = np.stack([random.uniform(0.1, 5.0, count), np.zeros(count)], axis=-1)
    fragment = np.stack([random.uniform(-8.0, 8.0, count), random.uniform(1.0, 9.0, count)], axis=-1)
    share = random.uniform(0.001, 0.999, count)
    point = left + share[:, None] * (right - left)
    edge = fragment + random.uniform(0.05, 0.95, count)[:, None] * (point - fragment)
    return left, right, fragment, edge, share


def test_the_papers_formula_is_the_lit_part_of_the_light() -> None:
    left, right, fragment, edge, share = triangles()
    np.testing.assert_allclose(model.angles_share(left, right, fragment, edge), share, atol=1e-10)


def test_directions_and_inverse_depthes_say_the_same_as_the_angles() -> None:
    left, right, fragment, edge, share = triangles()
    u, w = fragment[:, 0] / fragment[:, 1], 1.0 / fragment[:, 1]
    edge_u, edge_w = edge[:, 0] / edge[:, 1], 1.0 / edge[:, 1]
    np.testing.assert_allclose(model.edge_share(u, w, edge_u, edge_w, (right - left)[:, 0]), share, atol=1e-9)


def test_the_share_runs_from_0_at_the_left_end_to_1_at_the_right() -> None:
    left, right, fragment = np.array([0.0, 0.0]), np.array([2.0, 0.0]), np.array([0.5, 3.0])
    points = np.stack([np.linspace(0.0, 2.0, 101), np.zeros(101)], axis=-1)
    share = model.angles_share(left, right, fragment, fragment + 0.5 * (points - fragment))
    assert share[0] == pytest.approx(0.0, abs=1e-12)
    assert share[-1] == pytest.approx(1.0, abs=1e-12)
    assert (np.diff(share) > 0.0).all()


def test_influences_add_up_to_the_lit_part_and_mirror() -> None:
    i = np.linspace(0.0, 1.0, 33)
    toward_right, toward_left = model.influences(np.zeros(33), i)
    np.testing.assert_allclose(toward_right, i**2 / 2.0)
    np.testing.assert_allclose(toward_left, i - i**2 / 2.0)
    np.testing.assert_allclose(toward_right + toward_left + (1.0 - i), 1.0)
    assert (toward_right[-1], toward_left[-1]) == (0.5, 0.5)
    mirrored = model.influences(1.0 - i, np.ones(33))
    np.testing.assert_allclose(mirrored[0], toward_left, atol=1e-12)
    np.testing.assert_allclose(mirrored[1], toward_right, atol=1e-12)


@pytest.mark.parametrize("texels", [256, 1024])
@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_a_cards_edge_is_exact_to_a_texel_on_any_slope(texels: int, slope: float) -> None:
    """O1, and O8 with a tilted receiver. One texel moves the edge's shadow by that share of the penumbra.

    The edge is known to half a texel, and where the penumbra ends to one.
    """
    world, reach = Flatland((Card(-FAR, 0.3, H - h),), a, H, slope), 0.6
    x = np.linspace(-0.5, 2.0, 1201)
    points = world.receivers(x)
    moves = (
        2.0 * a * (1.0 / (H - h) - 1.0 / points[:, 1])
    )  # of the edge against the floor, from end to end of the light
    texel = 2.0 * reach / texels
    error = np.abs(model.line_visibility(world, x, texels, reach) - world.visibility(x))
    assert (error < 1.5 * texel / moves + 1e-3).all()
    assert error.max() < (0.04 if texels == 256 else 0.0125)


def test_the_order_breaks_where_the_penumbra_begins_and_is_back_where_it_ends() -> None:
    """The walk to the right of a card's right edge, in the right sample's map."""
    world, reach, texels = Flatland((Card(-FAR, 0.3, H - h),), a, H), 0.6, 2048
    u = reach * ((2.0 * np.arange(texels) + 1.0) / texels - 1.0)
    w = world.inverse_depth(a, u)
    _, _, found = model.occluding_edges(u, w, -2.0 * a)
    x = a + u / w
    x_in, x_out = (0.3 * H - a * h) / (H - h), (0.3 * H + a * h) / (H - h)
    inside = x[found]
    step = 2.0 * reach / texels * H
    assert found.sum() == pytest.approx((x_out - x_in) / step, abs=2)
    assert inside.min() == pytest.approx(x_in, abs=2.0 * step)
    assert inside.max() == pytest.approx(x_out, abs=2.0 * step)


def test_an_unshadowed_floor_has_no_edges() -> None:
    world = Flatland((), a, H, 0.2)
    u = np.linspace(-1.0, 1.0, 512)
    for sample, length in ((-a, 2.0 * a), (a, -2.0 * a)):
        assert not model.occluding_edges(u, world.inverse_depth(sample, u), length)[2].any()


CIRCLES = [(1.0, 1.0, 4.0, 0.063, 0.020), (2.0, 1.0, 6.0, 0.111, 0.033), (3.0, 1.0, 7.0, 0.0575, 0.0155)]
"""Half the light's length, radius and height of a circle; largest and mean error of the paper's algorithm where exactly
one end sees the floor. The first circle's are those of the paper's specification (3.7-6)."""


@pytest.mark.parametrize(("half", "radius", "height", "most", "mean"), CIRCLES)
def test_round_occluders_are_too_bright_by_as_much_as_the_paper_is(
    half: float, radius: float, height: float, most: float, mean: float
) -> None:
    """The edge is where the far sample's view touches the circle, for the whole penumbra."""
    world = Flatland((Circle(0.0, H - height, radius),), half, H)
    x = np.linspace(-14.0, 14.0, 1401)
    truth = world.visibility(x)
    one_end = model.is_seen(world, -half, x) ^ model.is_seen(world, half, x)
    error = (model.line_visibility(world, x, 16384, 8.0) - truth)[one_end]
    assert np.abs(error).max() == pytest.approx(most, abs=0.003)
    assert error.mean() == pytest.approx(mean, abs=0.001)
    repaired = (model.line_visibility(world, x, 16384, 8.0, repaired=True) - truth)[one_end]
    assert np.abs(repaired).max() < 0.4 * most


def test_a_narrow_strip_goes_unseen_and_is_found_from_both_sides_when_repaired() -> None:
    """O9: both ends see the middle, which the paper takes for all of the light."""
    world = Flatland((Card(-0.2, 0.2, H - h),), a, H)
    middle = np.zeros(1)
    assert closed_form.strip(middle, H, h, a, 0.2) == pytest.approx(0.5)
    assert model.line_visibility(world, middle, 1024, 0.6) == 1.0
    assert model.line_visibility(world, middle, 1024, 0.6, repaired=True) == pytest.approx(0.5, abs=0.01)


def test_what_only_the_middle_of_the_light_sees_takes_a_third_sample() -> None:
    """O10: neither end sees through the slit."""
    world = Flatland((Card(-FAR, -0.2, H - h), Card(0.2, FAR, H - h)), a, H)
    middle = np.zeros(1)
    assert model.line_visibility(world, middle, 1024, 0.6) == 0.0
    found = model.line_visibility(world, middle, 1024, 0.6, samples=3, repaired=True)
    assert found == pytest.approx(closed_form.slit(middle, H, h, a, 0.2), abs=0.02)
