"""Shadow maps that outlive a frame: they are kept where nothing changed, and never seen where something did.

The witness is the atlas's own draw arguments, read back after the frame: a draw without instances draws nothing.
"""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
import stage
from softshadows.gpu.budget import SUBMIT_MS
from softshadows.gpu.device import acquire
from softshadows.techniques import Adaptive, Technique, Uniform
from softshadows.techniques.light_pass import LightPass
from softshadows.techniques.line_shadow_maps.line_shadow_maps import LineShadowMapsPass
from softshadows.techniques.occluding_edges.occluding_edges import OccludingEdgesPass
from softshadows.visibility.maps.plan import plan_atlas
from softshadows.visibility.maps.shadow_maps import DRAW_BYTES, DRAWS, HEAD_BYTES, ShadowMaps

SIZE = (61, 45)
KEEPING: dict[str, Technique] = {
    "uniform": Uniform(grid=5, resolution=256),
    "adaptive": Adaptive(resolution=256),
    "adaptive-global": Adaptive(resolution=256, refinement="global"),
    "adaptive-cell": Adaptive(resolution=256, max_depth=2, filter="cell"),
}
"""Techniques whose maps all fit the atlas."""
BUDGET = {"uniform": 10, "adaptive": 100, "adaptive-global": 100, "adaptive-cell": 10}
"""MiB for the maps of one light, but not of two."""
OTHER = dataclasses.replace(stage.RECT, position=(-1.5, 3.0, 1.0), width=2.0)

every_keeper = pytest.mark.parametrize("name", list(KEEPING))


def renderer_of(made: ss.Scene, name: str) -> ss.Renderer:
    return ss.Renderer(made, technique=KEEPING[name], size=SIZE)


def maps_of(renderer: ss.Renderer, light: int = -1) -> ShadowMaps:
    """Those of a light, which by default took the last turn."""
    at_work = renderer.passes.technique
    if isinstance(at_work, LightPass | LineShadowMapsPass | OccludingEdgesPass):
        worker = at_work.by_light[light][0]
        return worker if isinstance(worker, ShadowMaps) else worker.maps.atlas
    return at_work._by_light[light][0]._maps  # type: ignore[union-attr]


def instances(renderer: ss.Renderer, light: int = -1) -> npt.NDArray[np.uint32]:
    """(chunks, DRAWS): the views that each draw of a light's last frame drew into."""
    words = np.frombuffer(acquire().device.queue.read_buffer(maps_of(renderer, light).draws, HEAD_BYTES), "<u4")
    return words.reshape(-1, DRAWS, DRAW_BYTES // 4)[:, :, 1]


def fresh(made: ss.Scene, camera: ss.Camera, name: str) -> tuple[ss.Frame, npt.NDArray[np.uint32]]:
    """What a new renderer makes of it."""
    with renderer_of(made, name) as renderer:
        return renderer.render(camera), instances(renderer)


def same_frame(one: ss.Frame, other: ss.Frame) -> bool:
    assert one.stats.shadow_maps == other.stats.shadow_maps
    assert one.stats.lookups_per_pixel == other.stats.lookups_per_pixel
    assert one.stats.warnings == other.stats.warnings
    return stage.same_bits(one.visibility, other.visibility)


def card_moved() -> list[ss.Node]:
    """The standard scene's nodes, the card 0.3 m aside and 0.2 m higher."""
    base, card, box = stage.standard_scene().nodes
    return [base, stage.moved(card, (0.3, 0.2, -0.1)), box]


@every_keeper
def test_a_frame_like_the_last_draws_nothing(name: str) -> None:
    made = stage.standard_scene()
    with renderer_of(made, name) as renderer:
        first = renderer.render(stage.CAMERA)
        drawn = instances(renderer)
        assert drawn.sum(axis=0).min() >= first.stats.shadow_maps, "every map has a view, which every draw fills"
        for _ in range(2):
            again = renderer.render(stage.CAMERA)
            assert not instances(renderer).any()
            assert same_frame(again, first)


@every_keeper
def test_what_changed_is_drawn_again_as_by_a_new_renderer(name: str) -> None:
    """The light moves and moves back, then an occluder does: no map from before is seen, nor is one of them missing."""
    nodes = stage.standard_scene().nodes
    steps = [(nodes, stage.RECT), (nodes, OTHER), (nodes, stage.RECT), (card_moved(), stage.RECT), (nodes, stage.RECT)]
    with renderer_of(stage.standard_scene(), name) as renderer:
        pictures = []
        for placed, light in steps:
            renderer.scene.nodes, renderer.scene.lights = placed, [light]
            frame = renderer.render(stage.CAMERA)
            expected, drawn = fresh(renderer.scene, stage.CAMERA, name)
            np.testing.assert_array_equal(instances(renderer), drawn)
            assert drawn.any()
            assert same_frame(frame, expected)
            pictures.append(frame.visibility)
    assert stage.same_bits(pictures[0], pictures[2])
    assert stage.same_bits(pictures[0], pictures[4])
    for changed in (pictures[1], pictures[3]):
        assert np.abs(changed - pictures[0]).mean() > 0.01, "the change is too small to show old maps"


@every_keeper
def test_a_light_that_only_shines_brighter_keeps_or_draws_the_same_maps(name: str) -> None:
    made = stage.standard_scene()
    with renderer_of(made, name) as renderer:
        first = renderer.render(stage.CAMERA)
        made.lights = [dataclasses.replace(stage.RECT, radiance=(1.0, 20.0, 3.0))]
        assert same_frame(renderer.render(stage.CAMERA), first)


CAMERAS = {
    "aside": ss.Camera((1.32, 2.3, 2.89), (0.06, 0.3, 0.05), 45.0),
    "nearer": ss.Camera((1.2, 2.1, 2.7), (0.05, 0.3, 0.05), 45.0),
    "turned": ss.Camera((1.3, 2.3, 2.9), (0.25, 0.3, 0.0), 45.0),
    "wider": ss.Camera((1.3, 2.3, 2.9), (0.05, 0.3, 0.05), 49.0),
}


@every_keeper
def test_after_a_small_step_of_the_camera_maps_serve_or_are_drawn_again(name: str) -> None:
    """Where looser fits are kept: they have other texels than new ones, so that single pixels at edges differ.

    By 0.01 in the mean at most.
    """
    made = stage.standard_scene()
    with renderer_of(made, name) as renderer:
        stage.drawn(renderer, stage.CAMERA)
        kept = redrawn = 0
        for step, camera in CAMERAS.items():
            frame = stage.drawn(renderer, camera)
            assert frame.stats.looser_fits
            drawn = instances(renderer).sum(axis=0).max()
            expected, all_drawn = fresh(made, camera, name)
            kept += drawn < all_drawn.sum(axis=0).max()
            redrawn += drawn > 0
            stage.check_visibility(frame)
            assert np.abs(frame.visibility - expected.visibility).mean() <= 0.01, step
            again = stage.drawn(renderer, camera)
            assert not instances(renderer).any(), f"{step}: what was drawn serves"
            assert same_frame(again, frame)
        assert kept > 0, "no step is small enough to keep anything"
        assert redrawn > 0, "no step is large enough to draw anything"


@every_keeper
def test_each_of_several_lights_keeps_its_own_maps(name: str) -> None:
    """Where they have room; only the one that moves is drawn again."""
    nodes = stage.standard_scene().nodes
    further = dataclasses.replace(OTHER, width=1.5)
    with renderer_of(ss.Scene(nodes, [stage.RECT, OTHER]), name) as renderer:
        first = renderer.render(stage.CAMERA)
        assert instances(renderer, 0).any()
        assert instances(renderer, 1).any()
        assert same_frame(renderer.render(stage.CAMERA), first)
        assert not instances(renderer, 0).any()
        assert not instances(renderer, 1).any()
        renderer.scene.lights = [stage.RECT, further]
        frame = renderer.render(stage.CAMERA)
        assert not instances(renderer, 0).any()
        assert instances(renderer, 1).any()
        expected = fresh(ss.Scene(nodes, [stage.RECT, further]), stage.CAMERA, name)[0]
        assert same_frame(frame, expected)


@pytest.mark.parametrize("name", ["line_shadow_maps", "occluding_edges"])
def test_each_of_several_line_lights_keeps_its_own_maps(name: str) -> None:
    light = stage.light_for(name)
    lights = [light, light.moved((0.4, 0.3, -0.2))]
    technique = stage.cheap(name)
    with ss.Renderer(ss.Scene(stage.standard_scene().nodes, lights), technique=technique, size=SIZE) as renderer:
        first = renderer.render(stage.CAMERA)
        assert all(instances(renderer, light).any() for light in (0, 1))
        assert same_frame(renderer.render(stage.CAMERA), first)
        assert not any(instances(renderer, light).any() for light in (0, 1))
    for layer, light in enumerate(lights):
        alone = stage.render(stage.standard_scene(light), technique, SIZE)
        assert stage.same_bits(first.visibility[layer], alone.visibility[0])


@every_keeper
def test_lights_without_room_for_all_maps_share_them(name: str) -> None:
    nodes = stage.standard_scene().nodes
    lights = [stage.RECT, OTHER]
    apart = fresh(ss.Scene(nodes, lights), stage.CAMERA, name)[0]
    with ss.Renderer(
        ss.Scene(nodes, lights), technique=KEEPING[name], size=SIZE, memory_budget=BUDGET[name]
    ) as renderer:
        for _ in range(2):
            assert same_frame(renderer.render(stage.CAMERA), apart)
            assert maps_of(renderer, 0) is maps_of(renderer, 1)
            assert instances(renderer).any()


@every_keeper
def test_lights_that_take_turns_do_not_see_each_others_maps(name: str) -> None:
    """Also not in later frames, when each finds the other's maps in the atlas; equal lights may share theirs."""
    nodes = stage.standard_scene().nodes
    alone = {light: fresh(ss.Scene(nodes, [light]), stage.CAMERA, name)[0] for light in (stage.RECT, OTHER)}
    assert np.abs(alone[stage.RECT].visibility - alone[OTHER].visibility).mean() > 0.01
    for lights in ([stage.RECT, OTHER], [OTHER, stage.RECT], [stage.RECT, stage.RECT]):
        with renderer_of(ss.Scene(nodes, lights), name) as renderer:
            for _ in range(3):
                frame = renderer.render(stage.CAMERA)
                for layer, light in enumerate(lights):
                    assert stage.same_bits(frame.visibility[layer], alone[light].visibility[0])
                assert frame.stats.shadow_maps == sum(alone[light].stats.shadow_maps for light in lights)


@pytest.mark.parametrize("samples_per_submit", [1, 7, 25, 1000])
def test_maps_that_all_fit_have_places_of_their_own(samples_per_submit: int) -> None:
    """However a frame is cut: else a cached map would be overdrawn by one of the last chunk."""
    pixels = stage.SIZE[0] * stage.SIZE[1]
    lookups_per_ms = pixels * samples_per_submit / SUBMIT_MS
    budget = SimpleNamespace(triangles_per_ms=1e12, lookups_per_ms=lookups_per_ms)
    gpu: Any = SimpleNamespace(limit=lambda _: 8192, budget=budget)
    scene: Any = SimpleNamespace(triangle_count=12)
    plan = plan_atlas(gpu, scene, stage.SIZE, samples=25, resolution=256, memory_budget=512)
    assert plan.holds_all
    assert len({sample % plan.samples_per_batch for sample in range(25)}) == 25
    assert [plan.starts_batch(chunk) for chunk in range(plan.chunks)] == [True] + [False] * (plan.chunks - 1)
