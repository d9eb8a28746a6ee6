"""Pictures of occluding edges: where a card casts a penumbra, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.techniques import OccludingEdges
from softshadows.techniques.occluding_edges.pictures import (
    EDGE_COLOR,
    all_pictures,
    edge_picture,
    penumbra_picture,
    read_edges,
)


def test_pixels_in_penumbra_are_coloured_and_lit_ones_are_not() -> None:
    made = stage.standard_scene(stage.LIGHTS["line"])
    technique = OccludingEdges(samples=2, penumbra="texture", resolution=256)
    with ss.Renderer(made, technique=technique, size=stage.SIZE) as renderer:
        frame = renderer.render(stage.CAMERA)
        edges = read_edges(renderer)
        pictures = all_pictures(renderer, frame)
    assert set(pictures) == {"edges-first", "edges-last", "penumbrae"}
    for picture in pictures.values():
        assert picture.dtype == np.float32
        assert 0.0 <= picture.min() <= picture.max() <= 1.0
    assert (edge_picture(edges, 0) == np.array(EDGE_COLOR, np.float32)).all(axis=-1).any()
    image, visibility = penumbra_picture(edges, frame), frame.visibility[0]
    coloured = image.max(axis=-1) > 0.5
    partly = frame.surface & (visibility > 0.1) & (visibility < 0.9)
    assert coloured[partly].mean() > 0.9
    assert coloured[frame.surface & (visibility == 1.0)].mean() < 0.2


def test_refusals() -> None:
    made = stage.standard_scene(stage.LIGHTS["line"])
    with ss.Renderer(made, technique="hard", size=stage.SIZE) as renderer:
        renderer.render(stage.CAMERA)
        with pytest.raises(ss.OptionError, match="occluding_edges"):
            read_edges(renderer)
    with ss.Renderer(made, technique=OccludingEdges(samples=2, resolution=64), size=stage.SIZE) as renderer:
        renderer.render(stage.CAMERA)
        with pytest.raises(ss.OptionError, match="sample"):
            edge_picture(read_edges(renderer), 2)
