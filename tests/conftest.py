"""What all tests share: no silent lack of a driver, the real scenes, and pictures of a comparison that failed.

With SOFTSHADOWS_EXPECT_ADAPTER=1 the whole run stops at once where there is no adapter. Without it every test that
needs one fails by itself; none of them skips.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from softshadows.errors import DeviceError
from softshadows.gpu.device import acquire

AMPLIFIED = 10.0
"""How much brighter the picture of a difference is than the difference."""

CompareVisibility = Callable[..., None]


def pytest_sessionstart(session: pytest.Session) -> None:
    if os.environ.get("SOFTSHADOWS_EXPECT_ADAPTER") == "1" and not session.config.option.collectonly:
        try:
            acquire()
        except DeviceError as error:
            pytest.exit(f"SOFTSHADOWS_EXPECT_ADAPTER=1, but {error}", returncode=1)


@pytest.fixture(scope="session")
def scenes_folder() -> Path:
    """The folder of real scenes that SOFTSHADOWS_SCENES names; skips where it is not set."""
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if not folder:
        pytest.skip("SOFTSHADOWS_SCENES does not name a folder of real scenes")
    return Path(folder)


@pytest.fixture
def compare_visibility(tmp_path: Path) -> CompareVisibility:
    """`check(found, expected, limit=..., share=0.0, mask=None)` fails where more than `share` of the pixels in
    `mask` differ by more than `limit`.

    found and expected are (height, width) floats. On failure the test's folder holds both as PNG, and their difference
    amplified.
    """

    def check(
        found: npt.NDArray[np.float32],
        expected: npt.NDArray[np.floating],
        *,
        limit: float,
        share: float = 0.0,
        mask: npt.NDArray[np.bool_] | None = None,
    ) -> None:
        mask = np.ones(found.shape, bool) if mask is None else mask
        assert mask.any(), "no pixel is compared: the test would pass whatever was rendered"
        difference = np.where(mask, found.astype(np.float64) - expected, 0.0)
        wrong = ~(np.abs(difference) <= limit)  # NaN is wrong
        if np.count_nonzero(wrong) <= share * np.count_nonzero(mask):
            return
        _save(tmp_path / "visibility.png", found)
        _save(tmp_path / "truth.png", expected)
        _save(tmp_path / "difference.png", 0.5 + 0.5 * AMPLIFIED * difference)
        row, column = np.unravel_index(np.argmax(np.nan_to_num(np.abs(difference), nan=np.inf)), difference.shape)
        pytest.fail(
            f"{np.count_nonzero(wrong)} of {np.count_nonzero(mask)} pixels differ by more than {limit:g}; at most "
            f"{share:g} of them may. The worst, row {row}, column {column}: {found[row, column]:.4f} instead of "
            f"{expected[row, column]:.4f}. Pictures (difference ×{AMPLIFIED:g}) in {tmp_path}"
        )

    return check


def _save(path: Path, image: npt.NDArray[np.floating]) -> None:
    levels = np.clip(np.nan_to_num(np.asarray(image, np.float64), nan=0.0) * 255.0, 0.0, 255.0)
    Image.fromarray(np.round(levels).astype(np.uint8)).save(path)
