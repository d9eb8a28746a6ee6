"""What every technique must hold, whatever its quality: tests over the list in softshadows.techniques."""

from __future__ import annotations

import dataclasses
import time
from functools import cache
from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.techniques import TECHNIQUES

ALL = list(TECHNIQUES)
SHADOWING = [name for name in TECHNIQUES if name != "none"]
CHANGED = 0.02
"""A pixel whose visibility moves by more than this has changed (reliability check R15)."""

all_techniques = pytest.mark.parametrize("name", ALL)
shadowing_techniques = pytest.mark.parametrize("name", SHADOWING)


@cache
def standard_frame(name: str) -> ss.Frame:
    """The standard scene under the technique's own kind of light."""
    return stage.render(stage.standard_scene(stage.light_for(name)), stage.cheap(name))


def kinds(name: str) -> list[Any]:
    """One light of every kind that the technique can do."""
    return [light for kind, light in stage.LIGHTS.items() if kind in TECHNIQUES[name].light_kinds]


# -- Values ------------------------------------------------------------------------------------------------------------


@all_techniques
def test_visibility_is_finite_and_between_0_and_1_for_every_kind_of_light(name: str) -> None:
    with ss.Renderer(stage.standard_scene(), technique=stage.cheap(name), size=stage.SIZE) as renderer:
        for light in kinds(name):
            renderer.scene.lights = [light]
            frame = renderer.render(stage.CAMERA)
            stage.check_visibility(frame)
            assert frame.facing[0].any()
            if name != "none":
                assert (frame.visibility[0][frame.facing[0]] < 0.5).any(), f"no shadow under a {light.kind} light"
                assert (frame.visibility[0][frame.facing[0]] > 0.5).any(), f"nothing lit under a {light.kind} light"


@all_techniques
def test_without_an_occluder_facing_pixels_are_fully_lit(name: str) -> None:
    scene = ss.Scene([stage.floor()])
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        for light in kinds(name):
            scene.lights = [light]
            frame = renderer.render(stage.CAMERA)
            assert frame.facing[0].sum() > 500
            assert (frame.visibility[0][frame.facing[0]] == 1.0).all(), light.kind


@shadowing_techniques
def test_behind_a_total_occluder_no_light_arrives(name: str) -> None:
    """A card 8 m wide between a 6 m floor and the lights; only the floor's middle, far from the card's edges."""
    scene = ss.Scene([stage.floor(), stage.card(-4.0, 4.0, -4.0, 4.0, 2.5)])
    camera = ss.Camera((0.4, 1.6, 2.2), (0.0, 0.0, 0.0), 45.0)
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        for light in kinds(name):
            scene.lights = [light]
            frame = renderer.render(camera)
            certain = frame.surface & (np.abs(frame.position[..., [0, 2]]).max(axis=-1) < 2.0)
            assert certain.sum() > 500
            assert (frame.visibility[0][certain] == 0.0).all(), light.kind


@shadowing_techniques
def test_light_of_no_size_casts_the_hard_shadow_of_its_centre(name: str) -> None:
    """Or, where a technique takes every light as its centre, size does not matter at all.

    A technique that draws no shadow maps has no texels to share with `hard`: its shadow is that of a ray.
    """
    small = {
        "rect": ss.RectLight(stage.RECT.position, stage.RECT.target, 0.0, 0.0, stage.WHITE),
        "disk": ss.DiskLight(stage.RECT.position, stage.RECT.target, 0.0, stage.WHITE),
        "line": ss.LineLight(stage.RECT.position, stage.RECT.position, stage.WHITE),
    }
    full = stage.light_for(name)
    scene = stage.standard_scene(small[full.kind])
    frame = stage.render(scene, stage.cheap(name))
    if frame.stats.shadow_maps == 0:
        assert stage.same_bits(frame.visibility, ss.truth.visibility(scene, frame, samples=1))
        return
    size_matters = not np.array_equal(frame.visibility, standard_frame(name).visibility)
    expected = stage.render(scene, stage.cheap("hard")) if size_matters else standard_frame(name)
    assert stage.same_bits(frame.visibility, expected.visibility)


@pytest.mark.parametrize("name", [name for name in SHADOWING if "rect" in TECHNIQUES[name].light_kinds])
def test_tiny_lights_tend_to_the_hard_shadow(name: str) -> None:
    """R12: a light of 1e-4 of the scene differs from the one of no size in at most 0.1 % of the pixels."""
    sizes = (6e-4, 0.0)
    tiny, none = (ss.RectLight(stage.RECT.position, stage.RECT.target, size, size, stage.WHITE) for size in sizes)
    a, b = (stage.render(stage.standard_scene(light), stage.cheap(name), (96, 72)) for light in (tiny, none))
    changed = np.abs(a.visibility - b.visibility) > CHANGED
    assert changed.mean() <= 1e-3


# -- Determinism and state ---------------------------------------------------------------------------------------------


@all_techniques
def test_same_bits_in_every_frame_and_every_renderer(name: str) -> None:
    """R19: 20 runs."""
    expected = standard_frame(name)
    for _ in range(2):
        scene = stage.standard_scene(stage.light_for(name))
        with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
            for _ in range(10):
                frame = renderer.render(stage.CAMERA)
                assert stage.same_bits(frame.visibility, expected.visibility)
                assert stage.same_bits(frame.color, expected.color)


@all_techniques
def test_a_changed_scene_equals_a_fresh_one(name: str) -> None:
    """Nodes move, lights change and come and go, everything is invalidated: never a trace of what was before."""
    light = stage.light_for(name)
    scene = stage.standard_scene(light)
    start = [node.transform for node in scene.nodes]
    elsewhere = stage.moved(scene.nodes[1], (0.3, 0.4, -0.2)).transform
    other_light = dataclasses.replace(stage.LIGHTS[light.kind], **_position(light, (-0.6, 3.5, 0.9)))

    def fresh() -> np.ndarray:
        copies = [ss.Node(node.mesh, node.transform, node.name) for node in scene.nodes]
        return stage.render(ss.Scene(copies, list(scene.lights), scene.camera), stage.cheap(name)).visibility

    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        first = renderer.render(stage.CAMERA).visibility
        assert stage.same_bits(first, standard_frame(name).visibility)

        scene.nodes[1].transform = elsewhere
        node_moved = renderer.render(stage.CAMERA).visibility
        assert stage.same_bits(node_moved, fresh())

        scene.lights = [other_light]
        assert stage.same_bits(renderer.render(stage.CAMERA).visibility, fresh())

        scene.lights = [light, other_light]
        two = renderer.render(stage.CAMERA).visibility
        assert stage.same_bits(two[:1], node_moved)

        renderer.invalidate()
        assert stage.same_bits(renderer.render(stage.CAMERA).visibility, two)

        scene.nodes[1].transform, scene.lights = start[1], [light]
        assert stage.same_bits(renderer.render(stage.CAMERA).visibility, first)

    if name != "none":
        assert not np.array_equal(node_moved, first)


def _position(light: Any, position: tuple[float, float, float]) -> dict[str, Any]:
    if light.kind == "line":
        return {"start": position, "end": (position[0] + 0.9, position[1], position[2])}
    return {"position": position}


@all_techniques
def test_lights_do_not_influence_each_other(name: str) -> None:
    lights = kinds(name)
    scene = stage.standard_scene()
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        scene.lights = lights
        together = renderer.render(stage.CAMERA).visibility
        scene.lights = lights[::-1]
        backwards = renderer.render(stage.CAMERA).visibility
        assert stage.same_bits(together, np.ascontiguousarray(backwards[::-1]))
        scene.lights = [lights[0], lights[0]]
        twice = renderer.render(stage.CAMERA).visibility
        assert stage.same_bits(twice[0], twice[1])
        assert stage.same_bits(twice[0], together[0])
        for index, light in enumerate(lights):
            scene.lights = [light]
            assert stage.same_bits(renderer.render(stage.CAMERA).visibility[0], together[index]), light.kind


# -- Sizes and counts --------------------------------------------------------------------------------------------------


@all_techniques
@pytest.mark.parametrize("size", [(37, 23), (1, 1), (1, 65), (130, 2)])
def test_odd_image_sizes(name: str, size: tuple[int, int]) -> None:
    frame = stage.render(stage.standard_scene(stage.light_for(name)), stage.cheap(name), size)
    stage.check_visibility(frame)
    assert frame.visibility.shape == (1, size[1], size[0])
    assert frame.color.shape == (size[1], size[0], 3)
    assert frame.surface.any()


@all_techniques
def test_scenes_with_nothing_or_little_in_them(name: str) -> None:
    light = stage.light_for(name)
    triangle = ss.Mesh(np.float32([[-1, 0, 1], [1, 0, 1], [0, 0, -1]]), np.uint32([[0, 1, 2]]), material=stage.MATT)
    scene = ss.Scene([], [light])
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        empty = renderer.render(stage.CAMERA)
        stage.check_visibility(empty)
        assert not empty.surface.any()

        scene.nodes = [ss.Node(ss.Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)))]
        assert not renderer.render(stage.CAMERA).surface.any()

        scene.nodes = [ss.Node(triangle)]
        one = renderer.render(stage.CAMERA)
        stage.check_visibility(one)
        assert one.surface.any()
        assert (one.visibility[0][one.facing[0]] > 1.0 - 1e-5).all()  # a variance may lose the last digits

        scene.lights = []
        dark = renderer.render(stage.CAMERA)
        assert dark.visibility.shape == (0, stage.SIZE[1], stage.SIZE[0])
        assert dark.facing.shape == dark.visibility.shape
        assert (dark.color == 0.0).all()
        assert np.array_equal(dark.surface, one.surface)


@all_techniques
def test_an_image_too_large_for_the_adapter_is_refused_at_once(name: str) -> None:
    scene = stage.standard_scene(stage.light_for(name))
    for size in [(16384, 16384), (200_000, 4)]:
        started = time.perf_counter()
        with pytest.raises(ss.DeviceError, match=r"[Ll]ower the"):
            stage.render(scene, stage.cheap(name), size)
        assert time.perf_counter() - started < 5.0


@all_techniques
def test_many_lights(name: str) -> None:
    """R26: every technique does a hundred, and the last one is what it is alone."""
    kind = "point" if "point" in TECHNIQUES[name].light_kinds else stage.light_for(name).kind
    random = np.random.default_rng(1)
    lights = []
    for x, y, z in random.uniform((-2.0, 2.0, -2.0), (2.0, 4.0, 2.0), (100, 3)):
        light = stage.LIGHTS[kind]
        lights.append(dataclasses.replace(light, **_position(light, (x, y, z))))
    technique = stage.cheap(name, resolution=16, grid=1, samples=2)
    scene = stage.standard_scene()
    scene.lights = lights
    frame = stage.render(scene, technique, (16, 16))
    stage.check_visibility(frame)
    scene.lights = lights[-1:]
    last = stage.render(scene, technique, (16, 16))
    assert stage.same_bits(frame.visibility[-1], last.visibility[0])


@all_techniques
def test_more_lights_than_a_buffer_holds_are_refused_by_their_number(name: str) -> None:
    """R26: visibility of so many lights that their buffer would exceed what any adapter binds, 4 GiB."""
    size = (2048, 2048)
    scene = stage.standard_scene()
    scene.lights = [stage.light_for(name)] * 300
    with pytest.raises(ss.DeviceError, match=r"visibility would take 4800 MiB.*Lower the .*number of lights"):
        stage.render(scene, stage.cheap(name), size)


def test_unknown_technique_names_the_known_ones() -> None:
    with pytest.raises(ss.OptionError) as error:
        ss.Renderer(stage.standard_scene(), technique="softest")
    assert all(name in str(error.value) for name in ALL)


@all_techniques
def test_a_light_the_technique_cannot_do_is_named_with_those_it_can(name: str) -> None:
    able = TECHNIQUES[name].light_kinds
    scene = stage.standard_scene()
    for kind, light in stage.LIGHTS.items():
        if kind in able:
            continue
        scene.lights = [stage.light_for(name), light]
        with pytest.raises(ss.OptionError, match="light 1") as error:
            stage.render(scene, stage.cheap(name))
        assert all(legal in str(error.value) for legal in able)


@pytest.mark.parametrize("size", [(0, 4), (4, -1), (4,), "large", None])
def test_a_senseless_size_is_refused(size: Any) -> None:
    with pytest.raises(ss.OptionError, match="size"):
        ss.Renderer(stage.standard_scene(), size=size)


# -- Geometry ----------------------------------------------------------------------------------------------------------


@all_techniques
def test_degenerate_triangles_change_nothing(name: str) -> None:
    """R21: points, slivers without area and doubled vertices, more of them than real triangles."""
    scene = stage.standard_scene(stage.light_for(name))
    for node in scene.nodes:
        mesh = node.mesh
        count = len(mesh.positions)
        middle = mesh.positions[mesh.triangles[0, :2]].mean(axis=0, keepdims=True)
        positions = np.concatenate([mesh.positions, mesh.positions[:1], middle])
        a, b, _ = mesh.triangles[0]
        extra = [(a, a, a), (a, a, b), (a, b, a), (0, count, 1), (a, count + 1, b)]
        triangles = np.concatenate([np.uint32(extra[:2]), mesh.triangles, np.uint32(extra[2:])])
        node.mesh = ss.Mesh(positions, triangles, material=mesh.material)
    frame = stage.render(scene, stage.cheap(name))
    assert stage.same_bits(frame.visibility, standard_frame(name).visibility)
    assert stage.same_bits(frame.color, standard_frame(name).color)


@all_techniques
def test_the_order_of_triangles_and_nodes_changes_nothing(name: str) -> None:
    """R17."""
    scene = stage.standard_scene(stage.light_for(name))
    random = np.random.default_rng(3)
    for node in scene.nodes:
        mesh = node.mesh
        node.mesh = ss.Mesh(mesh.positions, random.permutation(mesh.triangles), material=mesh.material)
    scene.nodes.reverse()
    frame = stage.render(scene, stage.cheap(name))
    assert stage.same_bits(frame.visibility, standard_frame(name).visibility)


@all_techniques
def test_a_mirrored_node_equals_a_mirrored_mesh(name: str) -> None:
    """The transform turns the mesh inside out; single-sided surfaces must still be seen from their front."""
    solid = stage.box((-0.3, 0.1, -0.4), (0.5, 0.7, 0.2), ss.Material("single-sided")).mesh
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    by_hand = ss.Mesh(solid.positions * np.float32([-1, 1, 1]), solid.triangles[:, ::-1], material=solid.material)
    frames = [
        stage.render(ss.Scene([stage.floor(), node], [stage.light_for(name)]), stage.cheap(name))
        for node in (ss.Node(solid, mirror), ss.Node(by_hand))
    ]
    assert stage.same_bits(frames[0].visibility, frames[1].visibility)
    assert stage.same_bits(frames[0].color, frames[1].color)
    assert (frames[0].position[..., 1] > 0.5).any(), "the box is not seen"


@all_techniques
def test_awkward_lights_stay_finite(name: str) -> None:
    """R24: below the floor, in its plane, inside a solid, touching one, edge on, turned away, far larger than all."""
    white = stage.WHITE
    places = [(0.0, -2.0, 0.0), (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.9, 0.4, 0.1), (0.9, 0.8, 0.1), (1.3, 2.3, 2.9)]
    lights: list[Any] = []
    for x, y, z in places:
        lights += [
            ss.RectLight((x, y, z), (x + 0.1, y - 1.0, z + 0.2), 0.8, 0.5, white, two_sided=True),
            ss.RectLight((x, y, z), (x + 1.0, y, z), 0.8, 0.5, white),
            ss.RectLight((x, y, z), (x, y + 1.0, z), 0.8, 0.5, white),
            ss.DiskLight((x, y, z), (x, y - 1.0, z), 0.4, white),
            ss.LineLight((x, y, z), (x + 0.7, y, z), white),
            ss.LineLight((x, y, z), (x, y + 0.7, z), white),
            ss.PointLight((x, y, z), white),
        ]
    lights += [
        ss.RectLight((0.0, 4.0, 0.0), (0.0, 0.0, 0.0), 1e4, 1e4, white),
        ss.RectLight((0.0, 4.0, 0.0), (0.0, 0.0, 0.0), 1e-6, 1e2, white),
        ss.DirectionalLight((1.0, 0.0, 0.0), white),
        ss.DirectionalLight((0.0, 1.0, 0.0), white),
    ]
    scene = stage.standard_scene()
    with ss.Renderer(scene, technique=stage.cheap(name, grid=3), size=(24, 18)) as renderer:
        for light in lights:
            if light.kind in TECHNIQUES[name].light_kinds:
                scene.lights = [light]
                stage.check_visibility(renderer.render(stage.CAMERA))


@pytest.mark.parametrize("name", [name for name in SHADOWING if "rect" in TECHNIQUES[name].light_kinds])
def test_a_light_behind_or_turned_away_gives_darkness(name: str) -> None:
    below = ss.RectLight((0.0, -2.0, 0.0), (0.0, 0.0, 0.0), 0.5, 0.5, stage.WHITE)
    away = ss.RectLight((0.0, 4.0, 0.0), (0.0, 9.0, 0.0), 0.5, 0.5, stage.WHITE)
    scene = ss.Scene([stage.floor()], [below, away])
    frame = stage.render(scene, stage.cheap(name))
    assert (frame.visibility[:, frame.surface] == 0.0).all()
    assert not frame.facing.any()


@all_techniques
def test_cameras_inside_things(name: str) -> None:
    """R23: in a solid, in a shadow, in the light, on the floor, at the light's position."""
    scene = stage.standard_scene(stage.light_for(name))
    center = tuple(stage.light_for(name).center)
    with ss.Renderer(scene, technique=stage.cheap(name), size=(24, 18)) as renderer:
        for position in [(0.9, 0.4, 0.1), (-0.3, 0.5, -0.1), center, (0.0, 0.0, 0.0), (-0.3, 1.1, -0.1)]:
            for target in [(0.7, 0.1, 0.3), (-2.0, 0.3, 1.0), (0.0, 9.0, 0.5)]:
                stage.check_visibility(renderer.render(ss.Camera(position, target, 60.0)))


# -- Invariance --------------------------------------------------------------------------------------------------------


def transformed(name: str, matrix: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """Visibility of the standard scene after scene, light and camera went through a similarity of this scale.

    With maps so fine that few texels turn where the boxes of turned occluders, and so the windows, are others. And with
    a fixed set of light samples: a technique that chooses them by what it sees may choose otherwise where rounding
    turns a single texel, and is then as right as before.
    """

    def point(p: Any) -> Any:
        return tuple(matrix[:3, :3] @ np.asarray(p, np.float64) + matrix[:3, 3])

    def turned(v: Any) -> Any:
        return tuple(matrix[:3, :3] @ np.asarray(v, np.float64) / scale)

    light = stage.light_for(name)
    if light.kind == "line":
        light = ss.LineLight(point(light.start), point(light.end), light.radiance)
    else:
        up = turned(light.axes[1])
        extent = (scale * light.width, scale * light.height)
        light = ss.RectLight(point(light.position), point(light.target), *extent, light.radiance, up=up)
    camera = stage.CAMERA
    camera = ss.Camera(point(camera.position), point(camera.target), camera.vertical_fov, up=turned((0.0, 1.0, 0.0)))
    nodes = [ss.Node(node.mesh, matrix @ node.transform) for node in stage.standard_scene().nodes]
    frame = stage.render(ss.Scene(nodes, [light], camera), stage.cheap(name, max_depth=0, resolution=2048), (96, 72))
    stage.check_visibility(frame)
    return frame.visibility[0]


@cache
def untransformed(name: str) -> np.ndarray:
    return transformed(name, np.eye(4))


@all_techniques
@pytest.mark.parametrize("scale", [1e-3, 0.37, 1e3])
def test_units_do_not_matter(name: str, scale: float, compare_visibility: Any) -> None:
    """R15: at most one pixel in a thousand changes."""
    found = transformed(name, np.diag([scale, scale, scale, 1.0]), scale)
    compare_visibility(found, untransformed(name), limit=CHANGED, share=1e-3)


@all_techniques
def test_place_does_not_matter(name: str, compare_visibility: Any) -> None:
    """R15. Two hundred metres from the origin float32 resolves 0.015 mm, of a scene 6 m wide."""
    matrix = np.eye(4)
    matrix[:3, 3] = (200.0, -60.0, 140.0)
    # One blocker tap more or less moves the whole filter of pcss, so a texel's rounding shows in more pixels (0.14 %).
    share = 2e-3 if name == "pcss" else 1e-3
    compare_visibility(transformed(name, matrix), untransformed(name), limit=CHANGED, share=share)


@all_techniques
@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_quarter_turns_do_not_matter(name: str, quarters: int, compare_visibility: Any) -> None:
    """R16: exact in floating point but for the order of sums, where a variance loses digits."""
    cos, sin = [(0, 1), (-1, 0), (0, -1)][quarters - 1]
    matrix = np.array([[cos, 0, sin, 0], [0, 1, 0, 0], [-sin, 0, cos, 0], [0, 0, 0, 1]], np.float64)
    compare_visibility(transformed(name, matrix), untransformed(name), limit=1e-4)


@all_techniques
def test_any_turn_does_not_matter(name: str, compare_visibility: Any) -> None:
    """R15, but for 7 pixels in a thousand: occluders' boxes follow the world's axes, and the maps' windows follow them.

    So the texels of a turned scene lie elsewhere, and along a shadow's edge a pixel can turn for one of 16 samples, or
    for another kernel where an edge's strength lies between two bands.
    """
    axis, angle = np.array([0.36, 0.48, 0.8]), 1.0
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    compare_visibility(transformed(name, matrix), untransformed(name), limit=CHANGED, share=7e-3)
