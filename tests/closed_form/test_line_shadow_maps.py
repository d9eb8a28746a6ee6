"""Soft shadow maps for linear lights: the paper's fidelity checks (numbered as there), its failures, the repairs.

Scenes are the closed forms O1, O7 to O10 (truth/closed_form.py): the floor is y = 0, the occluder lies at y = h, the
line at y = H along x, and the camera looks straight down from just below the occluder.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
import stage
from softshadows.errors import OptionError
from softshadows.gpu.device import acquire
from softshadows.techniques.line_shadow_maps.line_shadow_maps import LineShadowMaps
from softshadows.techniques.line_shadow_maps.pictures import channels_picture, read_maps, skins_picture
from softshadows.truth import closed_form

H, h, a, e, c = 10.0, 4.0, 1.0, 0.3, 0.2
FAR = 60.0
WHITE = (1.0, 1.0, 1.0)
ALONG = ss.LineLight((-a, H, 0.0), (a, H, 0.0), WHITE)
ACROSS = ss.LineLight((0.2, H, -0.6), (0.2, H, 0.6), WHITE)
HALF_PLANE = [(-FAR, e, -FAR, FAR)]
STRIP = [(-c, c, -FAR, FAR)]
SLIT = [(-FAR, -c, -FAR, FAR), (c, FAR, -FAR, FAR)]
PAPER: dict[str, Any] = {"samples": 2, "transition": "linear", "between": "ends"}
SEAM = 0.04
"""Metres beside x = 0 where O9 and O10 are flat and nothing else happens."""

Images = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


def looking_down(center: float) -> ss.Camera:
    """4 m of the floor along x; a tenth of a degree off, so that pixels do not line up with the occluder's edges."""
    fov = 2.0 * np.degrees(np.arctan(0.5 * 4.0 * 64 / 96 / (0.9 * h)))
    return ss.Camera((center, 0.9 * h, 0.0), (center, 0.0, 0.0), float(fov), up=(np.sin(0.002), 0.0, -np.cos(0.002)))


def look_down(occluders: list[Any], light: Any = ALONG, *, center: float = 0.5, **options: Any) -> Images:
    """(x, visibility), each (height, width), of the floor."""
    scene = ss.scenes.blocker(light_height=H, height=h, occluders=occluders, light=light, floor_half=8.0)
    frame = ss.render(scene, looking_down(center), technique=LineShadowMaps(**options), size=(96, 64))
    assert frame.facing.all()
    return frame.position[..., 0].astype(np.float64), frame.visibility[0].astype(np.float64)


def in_the_middle(x: npt.NDArray[np.float64], visibility: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return visibility[np.abs(x) < SEAM]


# -- The paper's own version -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("resolution", "limit"), [(256, 0.04), (1024, 0.01)])
@pytest.mark.parametrize("transition", ["linear", "rational"])
def test_o1_is_exactly_linear(resolution: int, limit: float, transition: str) -> None:
    """Check 1."""
    x, found = look_down(HALF_PLANE, **{**PAPER, "resolution": resolution, "transition": transition})
    assert np.abs(found - closed_form.half_plane(x, H, h, a, e)).max() <= limit


def tilted_floor(transition: str, resolution: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], float]:
    """O8: (visibility, truth, the largest deviation from it of a ramp that is linear in a map). The floor leans.

    In a map, where the light is seen up to (edge − u)/(inverse depth of edge − of floor), the closed form's ratio r is
    that of these denominators. A ramp that were linear on the floor itself would deviate by 0.042 here.
    """
    slope, drop, height = 0.5, 4.0, 6.0
    light = ss.LineLight((-a, height, 0.0), (a, height, 0.0), WHITE)
    edge = stage.quad([(-FAR, 0, -FAR), (-FAR, 0, FAR), (0, 0, FAR), (0, 0, -FAR)])
    floor = stage.quad([(x, slope * x - drop, z) for x, z in ((-6, -6), (-6, 6), (6, 6), (6, -6))])
    camera = ss.Camera((0.3, -0.5, 0.1), (0.0, -drop, 0.0), 50.0, up=(0.0, 0.0, -1.0))
    technique = LineShadowMaps(**{**PAPER, "transition": transition, "resolution": resolution})
    frame = ss.render(ss.Scene([edge, floor], [light]), camera, technique=technique, size=(96, 64))
    x = frame.position[..., 0].astype(np.float64)
    truth = closed_form.tilted_receiver(x, 0.0, height, slope, -drop, -a, a)
    # The floor's height at both ends of the penumbra: x1 = ±a in equation 1.
    low, high = (-drop * side / (height - slope * side) * slope - drop for side in (-a, a))
    ratio = (1.0 / height - 1.0 / (height - low)) / (1.0 / height - 1.0 / (height - high))
    return frame.visibility[0].astype(np.float64), truth, float(closed_form.tilted_receiver_deviation(ratio))


def test_o8_linear_ramp_errs_by_the_formula() -> None:
    """Check 2: the method's signature."""
    found, truth, deviation = tilted_floor("linear", 1024)
    assert deviation > 0.02
    assert np.abs(found - truth).max() == pytest.approx(deviation, abs=0.005)


def test_o8_rational_transition_is_exact_to_a_texel() -> None:
    found, truth, _ = tilted_floor("rational", 1024)
    texel = 1.0 / 150.0  # of the penumbra, at least 150 texels of the 1024 wide
    assert np.abs(found - truth).max() <= texel


@pytest.mark.parametrize("options", [PAPER, {"samples": 5}], ids=["paper", "repaired"])
def test_o7_edge_along_the_light_has_no_penumbra(options: dict[str, Any]) -> None:
    """Check 3."""
    x, found = look_down(HALF_PLANE, ACROSS, **{**options, "resolution": 512})
    assert set(np.unique(found)) == {0.0, 1.0}
    apart = np.abs(x - (e * H - 0.2 * h) / (H - h)) > 0.02
    assert (found == closed_form.parallel_edge(x, H, h, e, line=0.2))[apart].all()


def test_fully_lit_is_one_and_umbra_zero_exactly() -> None:
    """Checks 4 and 8."""
    for samples in (2, 3, 5, 9):
        x, found = look_down(HALF_PLANE, samples=samples, resolution=256)
        exact = closed_form.half_plane(x, H, h, a, e)
        beside = 0.05  # metres, more than a texel
        lit = closed_form.half_plane(x - beside, H, h, a, e) == 1.0
        dark = closed_form.half_plane(x + beside, H, h, a, e) == 0.0
        assert lit.any()
        assert dark.any()
        assert exact.min() == 0.0
        assert (found[lit] == 1.0).all()
        assert (found[dark] == 0.0).all()


def test_o9_paper_takes_what_both_ends_see_as_fully_lit() -> None:
    """Check 5: it must fail with two samples, and no longer entirely with three."""
    x, found = look_down(STRIP, center=0.3, **{**PAPER, "resolution": 512})
    assert (in_the_middle(x, found) == 1.0).all()
    x, found = look_down(STRIP, center=0.3, **{**PAPER, "resolution": 512, "samples": 3})
    assert in_the_middle(x, found) == pytest.approx(0.5, abs=0.02)


def test_o10_paper_takes_what_neither_end_sees_as_umbra() -> None:
    """Check 5."""
    x, found = look_down(SLIT, center=0.3, **{**PAPER, "resolution": 512})
    assert (in_the_middle(x, found) == 0.0).all()
    x, found = look_down(SLIT, center=0.3, **{**PAPER, "resolution": 512, "samples": 3})
    assert np.abs(found - closed_form.slit(x, H, h, a, c)).max() <= 0.02, "no discontinuity"


def test_samples_that_are_not_needed_change_nothing() -> None:
    """Check 7: to a texel of maps that are 100 texels across the penumbra."""
    _, two = look_down(HALF_PLANE, **{**PAPER, "resolution": 1024})
    _, three = look_down(HALF_PLANE, **{**PAPER, "resolution": 1024, "samples": 3})
    assert np.abs(two - three).max() <= 0.01


def test_two_samples_beat_ten_plain_ones() -> None:
    """Check 9."""
    x, found = look_down(HALF_PLANE, **{**PAPER, "resolution": 500})
    scene = ss.scenes.blocker(light_height=H, height=h, occluders=HALF_PLANE, light=ALONG, floor_half=8.0)
    ten = ss.techniques.Uniform(grid=10, resolution=500)
    plain = ss.render(scene, looking_down(0.5), technique=ten, size=(96, 64)).visibility[0]
    exact = closed_form.half_plane(x, H, h, a, e)
    assert np.sqrt(np.mean((found - exact) ** 2)) < 0.25 * np.sqrt(np.mean((plain - exact) ** 2))


# -- Channels and skins ------------------------------------------------------------------------------------------------


def test_channels_have_an_atom_at_a_half_and_skins_lie_along_the_edge() -> None:
    """Checks 6 and 10."""
    scene = ss.scenes.blocker(light_height=H, height=h, occluders=HALF_PLANE, light=ALONG, floor_half=8.0)
    technique = LineShadowMaps(**{**PAPER, "resolution": 256})
    with ss.Renderer(scene, technique=technique, size=(96, 64)) as renderer:
        renderer.render(looking_down(0.5))
        maps = read_maps(renderer)
    assert maps.samples == [0, 1]
    # The edge is the occluder's right one: seen from the light's end, it uncovers what its start does not see.
    start, end = (channels_picture(maps, sample)[..., 0] for sample in (0, 1))
    assert (start == 0.5).all()
    between = end[(end != 0.5)]
    assert between.size > 100
    assert between.min() < 0.05
    assert between.max() > 0.95
    assert np.histogram(between, 10, (0.0, 1.0))[0].min() > 0
    sources, targets = maps.skins["ends"] >> 8 & 0xFF, maps.skins["ends"] >> 16
    assert set(sources) == {0}
    assert set(targets) == {1}
    rows = maps.skins["texel"] >> 16
    assert len(rows) == len(np.unique(rows)), "one skin a row"
    picture = skins_picture(maps, 0)
    assert (picture == np.array((0.2, 0.5, 1.0), np.float32)).all(axis=2).sum() == len(rows)
    with pytest.raises(OptionError, match="sample 7"):
        channels_picture(maps, 7)


def test_a_small_picture_of_much_geometry_keeps_all_its_skins() -> None:
    """Which skins do not find a place in the list hangs on how threads come, and so does the frame."""
    scene = ss.scenes.atrium()
    scene.lights = [ss.LineLight((-1.0, 6.0, 0.0), (1.0, 6.0, 0.0), (10.0, 10.0, 10.0))]
    frames = [stage.render(scene, "line_shadow_maps", (96, 72)) for _ in range(2)]
    assert not any("skins" in warning for warning in frames[0].stats.warnings)
    assert stage.same_bits(frames[0].visibility, frames[1].visibility)


def test_pictures_need_a_frame_of_this_technique() -> None:
    with ss.Renderer(stage.standard_scene(ALONG), technique="hard", size=stage.SIZE) as renderer:
        renderer.render(stage.CAMERA)
        with pytest.raises(OptionError, match="line_shadow_maps"):
            read_maps(renderer)


# -- The repairs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", [2, 5, "auto"])
@pytest.mark.parametrize(("occluders", "formula"), [(STRIP, closed_form.strip), (SLIT, closed_form.slit)])
def test_o9_and_o10_repaired(samples: Any, occluders: list[Any], formula: Any) -> None:
    x, found = look_down(occluders, center=0.3, samples=samples, resolution=512)
    assert np.abs(found - formula(x, H, h, a, c)).max() <= 0.02


def test_samples_are_inserted_where_the_maps_contradict_each_other() -> None:
    """As the paper leaves gaps unseen, a slit asks for more samples than a half-plane; what is asked for is drawn."""
    counts = {}
    for name, occluders in (("half plane", HALF_PLANE), ("slit", [(-FAR, -0.02, -FAR, FAR), (0.02, FAR, -FAR, FAR)])):
        scene = ss.scenes.blocker(light_height=H, height=h, occluders=occluders, light=ALONG, floor_half=8.0)
        technique = LineShadowMaps(between="channels", resolution=512)
        frame = ss.render(scene, looking_down(0.0), technique=technique, size=(96, 64))
        counts[name] = frame.stats.shadow_maps
    assert counts == {"half plane": 3, "slit": 9}


@pytest.mark.parametrize("line", [0.2, 0.23])
def test_rows_of_samples_between_each_other_keep_an_edge_along_the_light_in_its_place(line: float) -> None:
    """O7 with rows wider than pixels: two samples share their rows, so the edge moves to a row's border."""
    rows = 32
    light = dataclasses.replace(ACROSS, start=(line, H, -0.6), end=(line, H, 0.6))
    x, found = look_down(HALF_PLANE, light, samples=9, resolution=rows)
    truth = closed_form.parallel_edge(x, H, h, e, line=line)
    assert abs((found - truth).mean()) * rows <= 0.2
    if line == 0.2:
        _, of_two = look_down(HALF_PLANE, light, samples=2, resolution=rows)
        assert abs((of_two - truth).mean()) * rows >= 0.3


def test_maps_and_channels_are_cached_while_the_view_asks_for_the_same() -> None:
    """Drawn once, and again whenever a fresh renderer would choose other windows; what is drawn is then the same."""
    scene = stage.standard_scene(stage.LIGHTS["line"])
    technique = LineShadowMaps(samples=3, resolution=256)
    frames, drawn = [], []
    with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:
        for fov in (45.0, 45.0, 47.0, 45.0, 47.0):
            frames.append(renderer.render(dataclasses.replace(stage.CAMERA, vertical_fov=fov)))
            state = renderer.passes.technique.by_light[0][0].maps.state  # type: ignore[union-attr]
            drawn.append(int(np.asarray(acquire().device.queue.read_buffer(state)).view("<u4")[0]))
    assert drawn == [0b111, 0, 0b111, 0b111, 0b111]
    assert stage.same_bits(frames[0].visibility, frames[1].visibility)
    assert stage.same_bits(frames[0].visibility, frames[3].visibility)
    assert stage.same_bits(frames[2].visibility, frames[4].visibility)


# -- Real scenes -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "paper", "repaired"),
    [("chair_line", 0.12, 0.018), ("bike_line", 0.11, 0.05), ("classroom_tube", 0.18, 0.09)],
)
def test_real_shots(name: str, paper: float, repaired: float, scenes_folder: Path) -> None:
    """Two of the paper's samples, and five repaired ones, in a small picture: its texels are coarse there."""
    shot = ss.load_shot(scenes_folder / "shots" / f"{name}.toml")
    size = (192, 144)
    errors = []
    truth = None
    for technique in (LineShadowMaps.preset("paper"), LineShadowMaps(samples=5)):
        frame = ss.render(shot.scene, shot.camera, technique=technique, size=size)
        truth = ss.truth.visibility(shot.scene, frame, samples=256)[0] if truth is None else truth
        mask = frame.surface & frame.facing[0]
        errors.append(ss.metrics.compare(frame.visibility[0], truth, mask=mask))
    assert errors[0].rmse <= paper
    assert errors[1].rmse <= repaired
    assert errors[1].leak_rate <= 5e-3
