"""Sample by sample: the walk of `bitmask` against rays by Embree to the same points of the light."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.lights.rows import row_samples
from softshadows.scene.geometry import flatten
from softshadows.scene.lights import Light
from softshadows.techniques.bitmask.bitmask import BitmaskPass
from softshadows.techniques.bitmask.pictures import look
from softshadows.truth.occluders import Occluders
from softshadows.truth.segments import Receivers, to_points

SIZE = (48, 36)
MOST_DIFFERENT = 1e-5
"""Share of samples: rays and rows round differently where a sample lies on an edge, within 1e-6 of the scene's size."""


def differing(scene: ss.Scene, camera: ss.Camera, rows: int) -> tuple[int, int]:
    """How many samples of all lights are not as Embree sees them, and how many there are."""
    embree = Occluders(flatten(scene))
    wrong = total = 0
    with ss.Renderer(scene, technique=ss.techniques.Bitmask(rows=rows), size=SIZE) as renderer:
        frame = renderer.render(camera)
        at_work = renderer.passes.technique
        assert isinstance(at_work, BitmaskPass)
        for index, light in enumerate(scene.lights):
            samples = row_samples(light, rows)
            points = light.center + samples.points @ light.axes[:2]
            visible = to_points(points, light, Receivers.of(frame), embree).visible(embree)
            hidden = look(at_work, light, index).hidden[frame.surface].reshape(visible.shape)
            on_light = samples.is_on_light.ravel()
            wrong += np.count_nonzero((hidden == visible)[:, on_light])
            total += visible[:, on_light].size
            share = np.where(frame.surface, 1.0, 1.0).astype(np.float32)
            share[frame.surface] = (~hidden[:, on_light]).mean(axis=1)
            np.testing.assert_allclose(frame.visibility[index], share, atol=1e-6)
    return wrong, total


def under(light: Callable[[ss.RectLight], Light], name: str = "figures") -> ss.Scene:
    """A built-in scene whose rectangle becomes another light."""
    scene = ss.scenes.make(name)
    (own,) = scene.lights
    assert isinstance(own, ss.RectLight)
    scene.lights = [light(own)]
    return scene


def line(own: ss.RectLight) -> Light:
    half = own.axes[0] * own.half_extent[0]
    return ss.LineLight(tuple(own.center - half), tuple(own.center + half), own.radiance)


def disk(own: ss.RectLight) -> Light:
    return ss.DiskLight(own.position, own.target, own.width / 2.0, own.radiance)


def turned_away(own: ss.RectLight) -> Light:
    return ss.RectLight(own.position, (0.0, 9.0, 0.0), own.width, own.height, own.radiance, two_sided=True)


def one_sided_line(own: ss.RectLight) -> Light:
    return ss.RectLight(own.position, own.target, own.width, 0.0, own.radiance)


def upright_line(own: ss.RectLight) -> Light:
    return ss.RectLight(own.position, own.target, 0.0, own.height, own.radiance)


def on_the_floor(own: ss.RectLight) -> Light:
    return ss.RectLight((0.5, 0.3, 1.2), (0.0, 0.3, 0.0), 0.6, 0.6, own.radiance, two_sided=True)


@pytest.mark.parametrize("rows", [4, 8, 16, 32])
def test_every_sample_is_as_rays_see_it(rows: int) -> None:
    scene = ss.scenes.figures()
    assert scene.camera is not None
    wrong, total = differing(scene, scene.camera, rows)
    assert total > 30_000
    assert wrong <= MOST_DIFFERENT * total


@pytest.mark.parametrize(
    "light", [line, disk, turned_away, one_sided_line, upright_line, on_the_floor], ids=lambda light: light.__name__
)
def test_so_it_is_with_every_kind_of_light(light: Callable[[ss.RectLight], Light]) -> None:
    scene = under(light)
    assert scene.camera is not None
    wrong, total = differing(scene, scene.camera, 8)
    assert wrong <= MOST_DIFFERENT * total


@pytest.mark.parametrize("name", ["sphere_cube", "room", "fence", "leaves"])
def test_so_it_is_in_other_scenes(name: str) -> None:
    scene = ss.scenes.make(name)
    assert scene.camera is not None
    wrong, total = differing(scene, scene.camera, 8)
    assert wrong <= MOST_DIFFERENT * total


def test_a_lamp_in_a_closed_shade_lights_the_shade_alone() -> None:
    """The light reaches into the solid, so that its near sides count too."""
    shade = stage.box((-0.5, 2.0, -0.5), (0.5, 3.0, 0.5))
    scene = ss.Scene([stage.floor(), shade], [ss.RectLight((0.0, 2.5, 0.0), (0.0, 0.0, 0.0), 0.4, 0.4, stage.WHITE)])
    frame = ss.render(scene, stage.CAMERA, technique="bitmask", size=SIZE)
    on_floor = frame.surface & (frame.position[..., 1] < 1e-3)
    assert on_floor.any()
    assert (frame.visibility[0][on_floor] == 0.0).all()


LID = 1.2
"""Metres: the top of the box in the two scenes below, which is closed and a metre wide."""


def boxed(light: Light) -> ss.Scene:
    """A floor, a closed box above it, and a card under its lid."""
    nodes = [stage.floor(), stage.box((-0.5, 0.2, -0.5), (0.5, LID, 0.5)), stage.card(-0.2, 0.1, -0.2, 0.3, 0.9)]
    return ss.Scene(nodes, [light])


def test_a_lamp_half_sunk_in_a_box() -> None:
    """Its lower half lies within the solid and lights its inside alone; an upright one cuts the lid."""
    for target in ((0.3, LID + 1.0, 2.0), (3.0, LID, 0.4)):
        lamp = ss.RectLight((0.1, LID, 0.1), target, 0.6, 0.5, stage.WHITE, two_sided=True)
        camera = ss.Camera((1.6, 2.3, 2.9), (0.05, 0.6, 0.05), 45.0)
        wrong, total = differing(boxed(lamp), camera, 8)
        assert wrong <= MOST_DIFFERENT * total


def test_a_receiver_within_a_solid() -> None:
    """The camera stands in the box: light from outside reaches nothing, a lamp inside what no card hides."""
    camera = ss.Camera((0.35, 0.4, 0.35), (-0.3, 0.8, -0.3), 80.0)
    outside = ss.RectLight((0.0, 3.0, 0.0), (0.0, 0.0, 0.0), 1.0, 1.0, stage.WHITE)
    inside = ss.RectLight((0.1, 1.1, 0.0), (0.0, 0.3, 0.0), 0.5, 0.5, stage.WHITE)
    frames = [ss.render(boxed(light), camera, size=SIZE) for light in (outside, inside)]
    assert (frames[0].visibility == 0.0).all()
    assert frames[1].visibility[frames[1].facing].mean() > 0.3
    for light in (outside, inside):
        wrong, total = differing(boxed(light), camera, 8)
        assert wrong <= MOST_DIFFERENT * total


def test_lights_without_size_take_a_ray_each() -> None:
    scene = ss.scenes.figures()
    assert scene.camera is not None
    (own,) = scene.lights
    scene.lights = [
        ss.PointLight(tuple(own.center), (9.0, 9.0, 9.0)), own, ss.DirectionalLight((0.3, -1.0, 0.2), (1.0, 1.0, 1.0))
    ]  # fmt: skip
    frame = ss.render(scene, scene.camera, technique="bitmask", size=SIZE)
    traced = ss.render(scene, scene.camera, technique=ss.techniques.Uniform(grid=1, visibility="ray"), size=SIZE)
    for index in (0, 2):
        assert stage.same_bits(frame.visibility[index], traced.visibility[index])
    truth = ss.truth.visibility(scene, frame, samples=256)
    assert np.abs(frame.visibility[1] - truth[1])[frame.facing[1]].mean() < 0.002


def test_refined_frames_converge() -> None:
    scene = ss.scenes.figures()
    assert scene.camera is not None
    technique = ss.techniques.Bitmask(rows=4)
    with ss.Renderer(scene, technique=technique, size=SIZE) as renderer:
        first = renderer.refine(scene.camera)
        truth = ss.truth.visibility(scene, first, samples=4096)[0]
        mask = first.surface & first.facing[0]
        for _ in range(15):
            last = renderer.refine(scene.camera)
    errors = [ss.metrics.compare(frame.visibility[0], truth, mask=mask).rmse for frame in (first, last)]
    assert errors[1] < 0.3 * errors[0]


def test_presets() -> None:
    preview = ss.techniques.Bitmask.preset("preview")
    assert (preview.rows, preview.offsets, preview.denoise) == (4, "stratified", True)
    assert ss.techniques.Bitmask.preset("reference").rows == 32


def test_denoising_takes_the_noise_of_stratified_offsets_away() -> None:
    """Offsets by pixel trade the lattice's bias for noise; the filter averages it."""
    scene = ss.scenes.figures()
    assert scene.camera is not None
    size, truth, errors = (128, 96), None, []
    for denoise in (False, True):
        technique = ss.techniques.Bitmask(rows=4, offsets="stratified", denoise=denoise)
        frame = ss.render(scene, scene.camera, technique=technique, size=size)
        truth = ss.truth.visibility(scene, frame, samples=1024)[0] if truth is None else truth
        errors.append(ss.metrics.compare(frame.visibility[0], truth, mask=frame.surface & frame.facing[0]))
    assert errors[1].rmse < errors[0].rmse
    assert max(abs(error.bias) for error in errors) < 0.002
