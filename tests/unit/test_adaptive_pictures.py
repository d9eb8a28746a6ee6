"""The debug pictures of adaptive sampling say what the frame's statistics say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.techniques.adaptive import pictures
from softshadows.techniques.adaptive.pictures import MARGIN, SCALE_HEIGHT, read_decisions

SIZE = (90, 68)
"""No multiple of a tile: tiles reach beyond the picture."""


def decisions(light: Any = stage.RECT, **options: Any) -> tuple[ss.Frame, pictures.Decisions, dict[str, Any]]:
    scene = stage.standard_scene(light)
    with ss.Renderer(scene, technique=stage.cheap("adaptive", **options), size=SIZE) as renderer:
        renderer.render(ss.Camera((0.4, 2.0, 2.5), (0.0, 0.2, 0.0), 45.0))  # leaves other look-ups behind
        frame = renderer.render(stage.CAMERA)
        return frame, read_decisions(renderer), pictures.all_pictures(renderer)


@pytest.mark.parametrize("options", [{}, {"refinement": "global"}, {"max_depth": 2}, {"max_depth": 0}], ids=str)
@pytest.mark.parametrize("kind", ["rect", "line"])
def test_look_ups_are_those_of_the_statistics(kind: str, options: dict[str, Any]) -> None:
    frame, found, shown = decisions(stage.LIGHTS[kind], **options)
    assert found.lookups.shape == frame.surface.shape
    assert found.lookups.mean() == pytest.approx(frame.stats.lookups_per_pixel, rel=1e-12)
    assert found.lookups.max() > 0
    np.testing.assert_array_equal(found.surface, frame.surface)
    width, height = SIZE
    assert shown["lookups"].shape == (height + SCALE_HEIGHT, width, 3)
    assert shown["comparison"].shape == (height, width, 3)
    cells = [max(found.lattice.rows - 1, 1), max(found.lattice.columns - 1, 1)]
    for name in ("light", "light-of-tile"):
        assert shown[name].shape[:2] == (
            pictures.CELL_PIXELS * cells[0] + 2 * MARGIN + SCALE_HEIGHT,
            pictures.CELL_PIXELS * cells[1] + 2 * MARGIN,
        )
    for image in shown.values():
        assert image.dtype == np.float32
        assert image.min() >= 0.0
        assert image.max() <= 1.0


def test_the_samples_seen_average_to_the_visibility() -> None:
    """Where a tile has all nine samples of depth 1, its leaves are equal: the trapezoid rule over the look-ups."""
    frame, found, _ = decisions(max_depth=1)
    whole = found.by_pixel(found.requested.all(axis=(2, 3))) & frame.surface
    assert whole.any()
    ramp = np.array([1.0, 2.0, 1.0]) / 4.0
    seen = sum(ramp[r] * ramp[c] * found.sees(r, c) for r in range(3) for c in range(3))
    np.testing.assert_allclose(np.asarray(seen)[whole], frame.visibility[0][whole], atol=1e-6)


def test_the_comparison_has_the_papers_colours() -> None:
    frame, found, shown = decisions()
    corners = np.sum([found.sees(r, c) for r in (0, 16) for c in (0, 16)], axis=0)
    for number in (1, 2, 3):
        assert (corners == number).any()
        assert (shown["comparison"][corners == number] == np.float32(pictures.COUNT_COLORS[number])).all()
    assert (shown["comparison"][(corners == 0) | (corners == 4)] == 0.0).all()
    assert (shown["comparison"][~frame.surface] == 0.0).all()


def test_a_finer_cell_is_shown_only_where_it_exists() -> None:
    _, found, _ = decisions()
    missing = ~found.by_pixel(found.present((4, 3, 5)))
    assert (pictures.comparison_picture(found, (4, 3, 5))[missing] == 0.0).all()


def test_illegal_choices_are_option_errors() -> None:
    _, found, _ = decisions(max_depth=1)
    with pytest.raises(ss.OptionError, match="cell"):
        pictures.comparison_picture(found, (2, 0, 0))
    with pytest.raises(ss.OptionError, match="tile"):
        pictures.tree_picture(found, (0, 99))
    with ss.Renderer(stage.standard_scene(), technique="hard", size=SIZE) as renderer:
        renderer.render(stage.CAMERA)
        with pytest.raises(ss.OptionError, match="adaptive"):
            read_decisions(renderer)
