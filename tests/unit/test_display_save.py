"""Display transform and files: what a picture looks like, what a file holds, and that nothing is left half-written."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from softshadows.errors import OptionError
from softshadows.image import files as save
from softshadows.image.display import automatic_exposure, display, encode_srgb, film_curve
from softshadows.image.files import save_frame, save_png


@pytest.fixture
def images() -> dict[str, np.ndarray]:
    """A frame of 5 × 7 pixels and two lights; some arrays are views that are not contiguous."""
    random = np.random.default_rng(0)
    return {
        "color": random.uniform(0.0, 4.0, (7, 5, 3)).astype(np.float32).swapaxes(0, 1),
        "visibility": random.uniform(0.0, 1.0, (5, 7, 2)).astype(np.float32).transpose(2, 0, 1),
        "position": random.normal(size=(5, 7, 3)).astype(np.float32)[::-1],
        "normal": random.normal(size=(5, 7, 3)).astype(np.float32),
        "depth": random.uniform(0.1, 9.0, (5, 7)).astype(np.float32),
        "surface": random.uniform(size=(5, 7)) > 0.3,
        "facing": random.uniform(size=(2, 5, 7)) > 0.3,
    }


# -- Display -----------------------------------------------------------------------------------------------------------


def test_black_is_black_brightest_is_white_and_grey_stays_grey() -> None:
    row = np.array([0.0, 0.01, 0.18, 1.0, 100.0, 1e30])[None, :, None].repeat(3, axis=2)
    shown = display(row, exposure=0.0)
    assert shown.dtype == np.uint8
    assert (shown[0, 0] == 0).all()
    assert (shown[0, 4:] >= 254).all()
    assert np.ptp(shown.astype(int), axis=2).max() <= 1
    assert (np.diff(shown[0, :, 1].astype(int))[:4] > 0).all()


def test_mid_grey_leaves_the_curve_near_mid_grey() -> None:
    assert film_curve(np.full((1, 3), 0.18))[0] == pytest.approx(0.213, abs=0.002)


def test_the_curve_never_darkens_as_light_grows() -> None:
    grey = np.geomspace(1e-4, 1e12, 2000)[:, None].repeat(3, axis=1)
    assert (np.diff(film_curve(grey), axis=0) >= 0.0).all()


def test_automatic_exposure_undoes_the_light_s_brightness() -> None:
    image = np.random.default_rng(1).uniform(0.0, 1.0, (40, 30, 3))
    assert automatic_exposure(image * 64.0) == pytest.approx(automatic_exposure(image) - 6.0)
    assert np.array_equal(display(image), display(image * 64.0))
    assert automatic_exposure(np.full((4, 4, 3), 0.18)) == pytest.approx(0.0, abs=1e-6)


def test_automatic_exposure_ignores_background_deep_umbra_and_broken_pixels() -> None:
    lit = np.full((10, 10, 3), 0.18)
    others = np.zeros((30, 10, 3))
    others[:10], others[10] = 1e-9, np.nan
    assert automatic_exposure(np.concatenate([lit, others])) == pytest.approx(automatic_exposure(lit))
    assert automatic_exposure(np.zeros((4, 4, 3))) == 0.0


def test_broken_pixels_are_black_or_white() -> None:
    image = np.ones((1, 3, 3))
    image[0, 0], image[0, 1] = np.nan, np.inf
    shown = display(image, exposure=0.0)
    assert (shown[0, 0] == 0).all()
    assert (shown[0, 1] >= 254).all()


@pytest.mark.parametrize("exposure", [np.nan, np.inf, 65.0])
def test_an_exposure_out_of_range_is_refused(exposure: float) -> None:
    with pytest.raises(OptionError, match="exposure"):
        display(np.zeros((2, 2, 3)), exposure=exposure)


def test_another_shape_is_refused() -> None:
    with pytest.raises(OptionError, match="shape"):
        display(np.zeros((2, 2)))


def test_srgb_encoding_of_known_values() -> None:
    np.testing.assert_allclose(encode_srgb(np.array([0.0, 0.001, 0.18, 1.0])), [0.0, 0.01292, 0.46136, 1.0], atol=1e-5)


# -- Files -------------------------------------------------------------------------------------------------------------


def test_npz_holds_every_array_without_pickles(tmp_path: Path, images: dict[str, np.ndarray]) -> None:
    save_frame(tmp_path / "frame.npz", **images)
    with np.load(tmp_path / "frame.npz", allow_pickle=False) as stored:
        assert set(stored.files) == set(images)
        for name, image in images.items():
            assert stored[name].dtype == image.dtype
            assert np.array_equal(stored[name], image)


def test_exr_holds_every_image_by_name_bit_for_bit(tmp_path: Path, images: dict[str, np.ndarray]) -> None:
    images["color"][0, 0] = [np.inf, 1e-30, 65504.0]
    save_frame(tmp_path / "frame.exr", **images)
    with OpenEXR.File(str(tmp_path / "frame.exr"), separate_channels=True) as file:
        stored = {name: channel.pixels for name, channel in file.channels().items()}
    expected = {"depth": images["depth"], "surface": images["surface"]}
    for name, letters in (("color", "RGB"), ("position", "XYZ"), ("normal", "XYZ")):
        expected |= {f"{name}.{letter}": images[name][..., index] for index, letter in enumerate(letters)}
    expected |= {f"{n}.{light}": images[n][light] for n, light in itertools.product(("visibility", "facing"), (0, 1))}
    assert set(stored) == set(expected)
    for name, pixels in expected.items():
        assert stored[name].dtype == np.float32
        assert np.array_equal(stored[name], pixels.astype(np.float32)), name


def test_png_is_the_displayed_picture(tmp_path: Path, images: dict[str, np.ndarray]) -> None:
    save_frame(tmp_path / "FRAME.PNG", **images, exposure=-1.0)
    with Image.open(tmp_path / "FRAME.PNG") as picture:
        assert picture.format == "PNG"
        assert np.array_equal(np.asarray(picture), display(images["color"], exposure=-1.0))


def test_data_pngs_hold_rounded_values_without_a_curve(tmp_path: Path, images: dict[str, np.ndarray]) -> None:
    visibility = images["visibility"][0]
    save_png(tmp_path / "visibility.png", visibility)
    save_png(tmp_path / "colors.png", images["color"] / 4.0)
    save_png(tmp_path / "bytes.png", np.arange(6, dtype=np.uint8).reshape(2, 3))
    with Image.open(tmp_path / "visibility.png") as picture:
        assert picture.mode == "L"
        assert np.abs(np.asarray(picture) / 255.0 - visibility).max() <= 0.5 / 255.0 + 1e-6
    with Image.open(tmp_path / "colors.png") as picture:
        assert np.array_equal(np.asarray(picture), np.rint(images["color"] / 4.0 * 255.0))
    with Image.open(tmp_path / "bytes.png") as picture:
        assert np.array_equal(np.asarray(picture), [[0, 1, 2], [3, 4, 5]])


@pytest.mark.parametrize("name", ["frame.jpg", "frame", "frame.exr.txt"])
def test_an_unknown_suffix_is_refused_with_the_legal_ones(
    tmp_path: Path, images: dict[str, np.ndarray], name: str
) -> None:
    with pytest.raises(OptionError, match=r"\.png, \.exr, \.npz"):
        save_frame(tmp_path / name, **images)
    with pytest.raises(OptionError, match=r"\.png"):
        save_png(tmp_path / name, images["depth"])
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_a_folder_in_the_way_and_another_shape_are_refused(
    tmp_path: Path, images: dict[str, np.ndarray]
) -> None:
    with pytest.raises(OptionError, match="does not exist"):
        save_frame(tmp_path / "missing" / "frame.npz", **images)
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(OptionError, match="is a folder"):
        save_frame(tmp_path / "folder.png", **images)
    with pytest.raises(OptionError, match="shape"):
        save_png(tmp_path / "data.png", np.zeros((2, 3, 4)))


@pytest.mark.parametrize("suffix", save.SUFFIXES)
def test_a_file_is_replaced_whole_and_a_link_s_target_is_left_alone(
    tmp_path: Path, images: dict[str, np.ndarray], suffix: str
) -> None:
    target = tmp_path / "target"
    target.write_text("untouched")
    path = tmp_path / f"frame{suffix}"
    path.symlink_to(target)
    save_frame(path, **images)
    assert not path.is_symlink()
    assert target.read_text() == "untouched"
    save_frame(path, **images)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == sorted(["target", path.name])


def test_a_failed_write_leaves_the_old_file_and_no_rubbish(
    tmp_path: Path, images: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")

    def half_write(part: Path, _channels: dict[str, np.ndarray]) -> None:
        part.write_bytes(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(save, "_write_exr", half_write)
    with pytest.raises(OSError, match="disk full"):
        save_frame(path, **images)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
