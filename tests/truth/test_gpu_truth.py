"""The GPU's rays as a second truth: against Embree ray by ray, against the closed forms, and where they must refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_truth import EDGE, FAR, ORACLES, RECT, assert_agrees, floor_frame, quad, scene_of

import softshadows as ss
from softshadows.errors import DeviceError, OptionError
from softshadows.truth import visibility, visibility_from_points
from softshadows.visibility.rays.cast import Caster
from stage import LIGHTS, standard_scene

SIZE = (96, 72)
SAMPLES = 64


def frame_of(scene: ss.Scene) -> ss.Frame:
    return ss.render(scene, technique="none", size=SIZE)


@pytest.mark.parametrize("name", ["sphere_cube", "leaves", "fence"])
def test_its_rays_are_embrees(name: str) -> None:
    """The bar is 1e-5 of the rays. Of these 1.2 million one differs, at a border of a mask of `leaves`."""
    scene = getattr(ss.scenes, name)()
    frame = frame_of(scene)
    embree, gpu = (visibility(scene, frame, SAMPLES, backend=backend) for backend in ("embree", "gpu"))
    rays = SAMPLES * np.count_nonzero(frame.surface)
    assert rays > 200_000
    assert np.mean((embree > 0.0) & (embree < 1.0)) > 0.05
    assert SAMPLES * np.abs(gpu - embree).sum() <= 1e-5 * rays


@pytest.mark.parametrize("kind", LIGHTS)
def test_every_kind_of_light(kind: str) -> None:
    """Below horizons, behind one-sided lights, with numbers of rays that fill no packet of four: the same bits."""
    scene = standard_scene(LIGHTS[kind])
    frame = frame_of(scene)
    embree, gpu = (visibility(scene, frame, 7, return_error=True, backend=b) for b in ("embree", "gpu"))
    assert embree[0].min() < embree[0].max()
    np.testing.assert_array_equal(gpu, embree)


@pytest.mark.parametrize("name", ["O1", "O1 line", "O4", "O6", "O12 point"])
def test_it_agrees_with_the_closed_form(name: str) -> None:
    scene, oracle = ORACLES[name]
    frame = floor_frame(np.linspace(-2.003, 2.0, 96), np.linspace(-0.41, 0.4, 6))
    found, error = visibility(scene, frame, 1024, return_error=True, backend="gpu")
    expected = oracle(frame.position[..., 0].astype(np.float64), frame.position[..., 1].astype(np.float64))
    assert_agrees(found[0], error[0], expected, 1024)


def test_points_of_the_light_on_any_number_of_threads() -> None:
    frame = floor_frame(np.linspace(-1.0, 2.0, 400), np.linspace(-0.4, 0.4, 40))
    scene = scene_of([RECT], quad(-FAR, EDGE))
    points = RECT.points(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9))
    embree, one, five = (
        visibility_from_points(scene, frame, points, light=RECT, **options)
        for options in ({}, {"backend": "gpu", "threads": 1}, {"backend": "gpu", "threads": 5})
    )
    np.testing.assert_array_equal(one, embree)
    np.testing.assert_array_equal(five, embree)


def test_nothing_blocks_where_nothing_is() -> None:
    frame = floor_frame(np.linspace(-1.0, 1.0, 8), np.zeros(2))
    assert visibility(ss.Scene(lights=[RECT]), frame, 16, backend="gpu").min() == 1.0
    frame.surface[:] = False
    assert visibility(scene_of([RECT], quad(-FAR, FAR)), frame, 16, backend="gpu").min() == 1.0


def test_a_ray_cut_short_is_no_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    cut_short = np.uint32(16)
    honest = Caster._some

    def some(self: Caster, packets: Any) -> Any:
        answers = honest(self, packets)
        answers[-1:] |= cut_short
        return answers

    monkeypatch.setattr(Caster, "_some", some)
    with pytest.raises(DeviceError, match="ended some walks"):
        visibility(scene_of([RECT], quad(-FAR, EDGE)), floor_frame(np.zeros(4), np.zeros(4)), 16, backend="gpu")


def test_other_backends_are_refused() -> None:
    frame = floor_frame(np.zeros(1), np.zeros(1))
    with pytest.raises(OptionError, match="embree, gpu, got 'optix'"):
        visibility(scene_of([RECT]), frame, 16, backend="optix")
    with pytest.raises(OptionError, match="backend"):
        visibility_from_points(scene_of([RECT]), frame, np.zeros((1, 3)), backend="")
