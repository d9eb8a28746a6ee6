"""Lights made of others: the sides of a polygon in its place."""

from __future__ import annotations

import numpy as np
import pytest

import softshadows as ss

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
