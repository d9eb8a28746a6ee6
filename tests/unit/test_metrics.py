"""Metrics on images whose figures can be counted by hand, and the gate on defects it must catch."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from softshadows import metrics
from softshadows.errors import DeviceError, OptionError

WIDTH, HEIGHT = 100, 40
RAMP = 20


def shadow(ramp: float = RAMP, middle: float = 50.0) -> np.ndarray:
    """Umbra left, lit right, a linear penumbra `ramp` pixels wide about x = `middle`; (40, 100) float32."""
    x = np.arange(WIDTH) + 0.5
    profile = np.clip((x - middle) / ramp + 0.5, 0.0, 1.0)
    return np.broadcast_to(profile, (HEIGHT, WIDTH)).astype(np.float32)


TRUTH = shadow()


def test_regions_are_counted_and_eroded() -> None:
    found = metrics.compare(TRUTH, TRUTH)
    assert (found.pixels, found.penumbra_pixels) == (4000, 20 * 40)
    assert found.umbra_pixels == found.lit_pixels == (40 - 4) * (40 - 4)  # two pixels less on each side
    assert [getattr(found, name) for name in found.as_dict() if not name.endswith("pixels")] == [0.0] * 9


def test_regions_at_their_limits() -> None:
    truth = np.full((5, 15), 0.02)
    truth[:, 5:10], truth[:, 10:] = 0.5, 0.98
    where = metrics.regions(truth)
    assert np.argwhere(where.umbra).tolist() == [[2, 2]]
    assert np.argwhere(where.lit).tolist() == [[2, 12]]
    assert np.count_nonzero(where.penumbra) == 25
    assert metrics.compare(truth + 1e-6, truth + 1e-6).umbra_pixels == 0


def test_what_the_mask_leaves_out_is_no_region_and_may_hold_anything() -> None:
    mask = np.ones(TRUTH.shape, bool)
    mask[20, 20] = False
    broken = TRUTH.copy()
    broken[20, 20] = np.nan
    found = metrics.compare(broken, TRUTH, mask)
    assert (found.pixels, found.umbra_pixels) == (3999, 36 * 36 - 25)
    assert found.max == 0.0


def test_figures_by_hand() -> None:
    visibility = TRUTH.astype(np.float64)
    visibility[10, 10] += 0.4  # a leak
    visibility[10, 90] -= 0.3  # a false shadow
    visibility[:, 50] += 0.1  # within the penumbra
    found = metrics.compare(visibility, TRUTH.astype(np.float64))
    squares = 0.4**2 + 0.3**2 + 40 * 0.1**2
    assert found.rmse == pytest.approx(np.sqrt(squares / 4000))
    assert found.penumbra_rmse == pytest.approx(np.sqrt(40 * 0.1**2 / 800))
    assert found.bias == pytest.approx((0.4 - 0.3 + 40 * 0.1) / 4000)
    assert found.max == pytest.approx(0.4)
    assert found.p99 == pytest.approx(0.1)  # 42 of 4000 pixels err, and 1 % are 40
    assert found.p99_9 == pytest.approx(0.1)
    assert found.leak_rate == found.false_shadow_rate == pytest.approx(1 / (36 * 36))
    assert found.penumbra_width_error == pytest.approx(2 / 640)  # both failures; 16 columns lie between 10 % and 90 %


def test_limits_of_leak_and_false_shadow_are_not_failures() -> None:
    found = metrics.compare(np.clip(TRUTH.astype(np.float64), 0.1, 0.9), TRUTH)
    assert (found.leak_rate, found.false_shadow_rate) == (0.0, 0.0)
    assert not metrics.leak_mask(np.full((9, 9), 0.1), np.zeros((9, 9))).any()
    assert metrics.leak_mask(np.full((9, 9), 0.11), np.zeros((9, 9))).sum() == 25
    assert not metrics.false_shadow_mask(np.full((9, 9), 0.9), np.ones((9, 9))).any()
    assert metrics.false_shadow_mask(np.full((9, 9), 0.89), np.ones((9, 9))).sum() == 25


def test_empty_regions_give_zero_and_say_so() -> None:
    found = metrics.compare(np.ones((9, 9)), np.ones((9, 9)))
    assert (found.leak_rate, found.umbra_pixels, found.penumbra_rmse, found.penumbra_pixels) == (0.0, 0, 0.0, 0)
    nothing = metrics.compare(TRUTH, TRUTH, np.zeros(TRUTH.shape, bool))
    assert set(nothing.as_dict().values()) == {0.0}


def test_a_comparison_is_json() -> None:
    found = metrics.compare(shadow(30), TRUTH)
    assert json.loads(json.dumps(found.as_dict())) == found.as_dict()


def leaking(image: np.ndarray) -> np.ndarray:
    image[10:14, 10:14] = 0.3
    return image


def shadowed(image: np.ndarray) -> np.ndarray:
    image[10:14, 80:84] = 0.5
    return image


DEFECTS = {
    "inverted": (lambda image: 1.0 - image, "leak_rate", 0.5),
    "all lit": (np.ones_like, "leak_rate", 0.5),
    "all dark": (np.zeros_like, "false_shadow_rate", 0.5),
    "mirrored": (lambda image: image[:, ::-1], "false_shadow_rate", 0.5),
    "a leak of 16 pixels": (leaking, "leak_rate", 1e-3),
    "a false shadow of 16 pixels": (shadowed, "false_shadow_rate", 1e-3),
    "a missing clamp": (lambda image: image * 1.2, "bias", 0.05),
    "too dark throughout": (lambda image: image * 0.95, "bias", 0.02),
    "a hard shadow": (np.round, "penumbra_rmse", 0.2),
    "one pixel aside": (lambda image: np.roll(image, 1, axis=1), "penumbra_rmse", 0.04),
    "a penumbra too wide": (lambda image: shadow(40), "penumbra_width_error", 0.9),
    "a penumbra too narrow": (lambda image: shadow(10), "penumbra_width_error", 0.4),
    "five bands": (lambda image: np.round(image * 5) / 5, "penumbra_rmse", 0.04),
    "one stray pixel": (lambda image: np.where(np.arange(4000).reshape(40, 100) == 1010, 1.0, image), "max", 0.99),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_the_gate_catches(name: str) -> None:
    defect, figure, at_least = DEFECTS[name]
    found = metrics.compare(defect(TRUTH.copy()), TRUTH)
    assert abs(getattr(found, figure)) >= at_least


def test_signs_of_bias_and_width() -> None:
    assert metrics.compare(TRUTH + np.float32(0.05), TRUTH).bias == pytest.approx(0.05)
    assert metrics.compare(TRUTH - np.float32(0.05), TRUTH).bias == pytest.approx(-0.05)
    assert metrics.penumbra_width_error(shadow(40), TRUTH) == pytest.approx(1.0)
    assert metrics.penumbra_width_error(shadow(10), TRUTH) == pytest.approx(-0.5)
    assert metrics.penumbra_width_error(np.round(TRUTH), TRUTH) == -1.0
    assert metrics.penumbra_width_error(TRUTH, np.round(TRUTH)) == 640.0


@given(arrays(np.float32, (12, 13), elements=st.floats(0, 1, width=32)), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_figures_hang_together(truth: np.ndarray, seed: int) -> None:
    random = np.random.default_rng(seed)
    visibility, mask = random.random((12, 13), np.float32), random.random((12, 13)) < 0.9
    found = metrics.compare(visibility, truth, mask)
    assert abs(found.bias) <= found.rmse + 1e-12
    assert found.rmse <= found.max + 1e-12
    assert found.p99 <= found.p99_9 <= found.max
    assert found.umbra_pixels + found.lit_pixels + found.penumbra_pixels <= found.pixels == mask.sum()
    turned = metrics.compare(np.ascontiguousarray(visibility.T), truth.T, mask.T)
    assert turned.as_dict() == pytest.approx(found.as_dict())


@pytest.mark.parametrize(("width", "spacing"), [(20.0, 1.0), (7.3, 0.5)])
def test_penumbra_width_of_a_ramp(width: float, spacing: float) -> None:
    profile = shadow(width, middle=48.7)[0]
    assert metrics.penumbra_width(profile, spacing) == pytest.approx(0.8 * width * spacing, rel=5e-3)
    assert metrics.penumbra_width(profile[::-1], spacing) == pytest.approx(0.8 * width * spacing, rel=5e-3)


def test_penumbra_width_of_steps_rows_columns_and_flat_profiles() -> None:
    assert metrics.penumbra_width(np.array([0.0, 0.0, 1.0, 1.0])) == pytest.approx(0.8)
    assert metrics.penumbra_width(TRUTH).shape == (HEIGHT,)
    np.testing.assert_allclose(metrics.penumbra_width(TRUTH), 16.0, rtol=1e-4)
    assert np.isnan(metrics.penumbra_width(np.ascontiguousarray(TRUTH.T))).all()
    assert np.isnan(metrics.penumbra_width(np.array([1.0, 1.0, 1.0])))
    assert np.isnan(metrics.penumbra_width(np.array([0.0, 0.5, 0.8])))


def test_error_image_colours() -> None:
    truth = np.full((1, 5), 0.5, np.float32)
    visibility = np.array([[0.5, 0.9, 0.1, 0.6, 0.5]], np.float32)
    mask = np.array([[True, True, True, True, False]])
    right, light, dark, half, outside = metrics.signed_error_image(visibility, truth, mask, amplification=5.0)[0]
    assert right.tolist() == [1.0, 1.0, 1.0]
    assert light[0] > light[1] > light[2]
    assert dark[2] > dark[1] > dark[0]
    np.testing.assert_allclose(half, (1.0 + light) / 2.0, atol=1e-6)
    assert len(set(outside.tolist())) == 1
    image = metrics.signed_error_image(shadow(30), TRUTH)
    assert image.shape == (HEIGHT, WIDTH, 3)
    assert image.dtype == np.float32


def test_the_worst_region_holds_the_largest_sum_of_squares() -> None:
    """Two faults: a small deep one wins over a large shallow one; the mask hides it; the border cuts the square."""
    truth = np.ones((40, 60), np.float32)
    visibility = truth.copy()
    visibility[5:15, 5:15] = 0.9
    visibility[30:34, 50:54] = 0.0
    worst = metrics.worst_region(visibility, truth, side=8)
    assert worst is not None
    assert (worst.width, worst.height) == (8, 8)
    assert worst.x <= 50 <= 53 < worst.x + 8
    assert worst.y <= 30 <= 33 < worst.y + 8
    assert worst.rmse == pytest.approx(np.sqrt(16 / 64))
    masked = metrics.worst_region(visibility, truth, np.arange(60) < np.full((40, 1), 40), side=10)
    assert masked is not None
    assert (masked.x, masked.y) == (5, 5)
    assert masked.rmse == pytest.approx(0.1)
    whole = metrics.worst_region(visibility, truth, side=100)
    assert whole is not None
    assert whole[:4] == (0, 0, 60, 40)
    assert metrics.worst_region(truth, truth) is None
    with pytest.raises(OptionError, match="side"):
        metrics.worst_region(visibility, truth, side=0)


@pytest.mark.parametrize(
    ("visibility", "truth", "mask", "message"),
    [
        (TRUTH[None], TRUTH, None, "shape"),
        (TRUTH[None], TRUTH[None], None, "height, width"),
        (TRUTH[:, 1:], TRUTH, None, "shape"),
        (TRUTH, TRUTH, np.ones(TRUTH.shape, np.uint8), "mask"),
        (TRUTH, TRUTH, np.ones((2, 2), bool), "mask"),
        (TRUTH > 0.5, TRUTH, None, "floating"),
        (np.full_like(TRUTH, np.nan), TRUTH, None, "visibility must be finite"),
        (TRUTH, np.full_like(TRUTH, np.inf), None, "truth must be finite"),
        (TRUTH, TRUTH + np.float32(0.1), None, "0..1"),
    ],
)
def test_images_of_another_kind_are_refused(visibility, truth, mask, message: str) -> None:
    for metric in (metrics.compare, metrics.leak_mask, metrics.penumbra_width_error, metrics.signed_error_image):
        with pytest.raises(OptionError, match=message):
            metric(visibility, truth, mask)


def test_options_out_of_range_are_refused() -> None:
    with pytest.raises(OptionError, match="amplification"):
        metrics.signed_error_image(TRUTH, TRUTH, amplification=0.0)
    with pytest.raises(OptionError, match="spacing"):
        metrics.penumbra_width(TRUTH, spacing=np.nan)
    for profile in (np.float32(1.0), np.ones(1), np.array([0, 1]), np.array([0.0, np.nan, 1.0])):
        with pytest.raises(OptionError, match="profile"):
            metrics.penumbra_width(profile)


PICTURE = np.random.default_rng(0).random((24, 32, 3), np.float32)


def test_flip_of_equal_and_of_different_pictures() -> None:
    assert metrics.flip(PICTURE, PICTURE).mean == 0.0
    found = metrics.flip(PICTURE * np.float32(0.8), PICTURE)
    assert found.map.shape == (24, 32)
    assert found.map.dtype == np.float32
    assert 0.05 < found.mean < 0.6
    assert found.mean == pytest.approx(found.map.mean(), abs=1e-5)
    assert metrics.flip(PICTURE * np.float32(0.8), PICTURE, linear=True).mean != found.mean
    assert metrics.flip((PICTURE * 0.8).astype(np.float64), PICTURE).mean == pytest.approx(found.mean, abs=1e-5)
    columns_first = np.asfortranarray(PICTURE * np.float32(0.8))
    assert metrics.flip(columns_first, PICTURE).mean == found.mean


@pytest.mark.parametrize(
    "picture",
    [
        PICTURE[..., 0],
        PICTURE[..., :2],
        PICTURE[:10],
        np.full_like(PICTURE, np.nan),
        PICTURE + np.float32(0.5),
        (255 * PICTURE).astype(np.uint8),
        np.zeros((0, 4, 3), np.float32),
    ],
    ids=["grey", "two channels", "another size", "NaN", "above 1", "bytes", "empty"],
)
def test_flip_refuses(picture: np.ndarray) -> None:
    with pytest.raises(OptionError):
        metrics.flip(picture, PICTURE)
    with pytest.raises(OptionError):
        metrics.flip(PICTURE, picture)


def test_flip_survives_an_evaluator_that_exits(monkeypatch: pytest.MonkeyPatch) -> None:
    import flip_evaluator

    with pytest.raises(OptionError, match="pixels_per_degree"):
        metrics.flip(PICTURE, PICTURE, pixels_per_degree=-1.0)
    monkeypatch.setattr(flip_evaluator, "evaluate", lambda *args, **options: sys.exit(1))
    with pytest.raises(OptionError, match="refused"):
        metrics.flip(PICTURE, PICTURE)


def test_flip_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    with pytest.raises(DeviceError, match="pip install flip-evaluator"):
        metrics.flip(PICTURE, PICTURE)
