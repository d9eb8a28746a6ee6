"""Shadow maps of solids drawn without the triangles that look away from the light: the same maps."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
import wgpu

import softshadows as ss
import stage
from softshadows.gpu.device import acquire
from softshadows.gpu.layout import dtype
from softshadows.scene.builtin import shapes
from softshadows.techniques.light_pass import LightPass
from softshadows.visibility.maps import shadow_maps

GRID = 3
EDGE_ON_SHARE = 1e-5  # of the texels
EDGE_ON_CLOSENESS = 2e-4
KERNEL = """
@group(0) @binding(0) var atlas: texture_depth_2d;
@group(0) @binding(1) var<storage, read_write> depths: array<f32>;
@compute @workgroup_size(1) fn cs_read(@builtin(global_invocation_id) id: vec3u) {
    depths[id.y * textureDimensions(atlas).x + id.x] = textureLoad(atlas, id.xy, 0);
}
"""


def leaf() -> ss.Node:
    """A card with holes."""
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[..., 3] = 255 * (np.indices((8, 8)).sum(axis=0) % 2)
    material = ss.Material("leaf", base_color_texture=ss.Texture(pixels, nearest=True), alpha_cutoff=0.5)
    corners = np.array([(-1.5, 0.6, 0.6), (-1.5, 0.6, 1.4), (0.2, 0.9, 1.4), (0.2, 0.9, 0.6)], np.float32)
    texcoords = np.array([[(0, 0), (0, 1), (1, 1), (1, 0)]] * 2, np.float32)
    return ss.Node(ss.Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), texcoords=texcoords, material=material))


def scene(light: ss.Light) -> ss.Scene:
    """Solids, some that overlap, one mirrored; an open sheet; a masked card."""
    ball = shapes.mesh(shapes.sphere(762, 0.4), stage.MATT)
    ring = shapes.mesh(shapes.torus(0.35, 0.12), stage.MATT)
    mirrored = np.diag([-1.0, 1.5, 1.0, 1.0])
    mirrored[:3, 3] = (-0.9, 0.7, -0.9)
    nodes = [
        stage.floor(),
        stage.card(-0.9, 0.2, -0.7, 0.45, 1.1),
        stage.box((0.55, 0.0, -0.35), (1.2, 0.8, 0.5)),
        stage.moved(ss.Node(ball), (0.6, 0.7, 0.3)),
        ss.Node(ring, mirrored),
        leaf(),
    ]
    return ss.Scene(nodes, [light], stage.CAMERA)


def surrounded() -> ss.Scene:
    """A lamp that looks all around, with a box and a wall on each of its six sides."""
    nodes = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for distance, half in ((1.0, 0.3), (3.0, 2.6)):
                center, extent = np.zeros(3), np.full(3, half)
                center[axis], extent[axis] = side * distance, 0.1
                nodes.append(stage.box((center - extent).tolist(), (center + extent).tolist()))
    return ss.Scene(nodes, [ss.PointLight((0.05, 0.02, -0.04), stage.WHITE)])


def depths(renderer: ss.Renderer) -> npt.NDArray[np.float32]:
    """The maps of the renderer's last frame, (size, size) float32."""
    maps = maps_of(renderer)
    device, size = acquire().device, maps.plan.atlas_size
    result = device.create_buffer(size=4 * size**2, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    module = device.create_shader_module(code=KERNEL)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "cs_read"})
    resources = [maps.depth.create_view(), {"buffer": result}]
    bindings = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0),
        entries=[{"binding": i, "resource": resource} for i, resource in enumerate(resources)],
    )
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(size, size)
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(bytes(device.queue.read_buffer(result)), np.float32).reshape(size, size)


def maps_of(renderer: ss.Renderer) -> shadow_maps.ShadowMaps:
    assert isinstance(renderer.passes.technique, LightPass)
    ((maps, _),) = renderer.passes.technique.by_light
    return maps


def rendered(scene: ss.Scene, camera: ss.Camera = stage.CAMERA) -> tuple[ss.Frame, npt.NDArray[np.float32], set[int]]:
    """A frame, its shadow maps, and which cube faces they show."""
    technique = ss.techniques.Uniform(grid=GRID, resolution=256)
    with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:
        frame = renderer.render(camera)
        maps = maps_of(renderer)
        views = np.frombuffer(bytes(acquire().device.queue.read_buffer(maps.views)), dtype(shadow_maps.ShadowView))
        faces = set((np.flatnonzero(views["size"][:, 0]) % shadow_maps.FACES).tolist())
        return frame, depths(renderer), faces


@pytest.fixture
def culling(monkeypatch: pytest.MonkeyPatch) -> Callable[[bool], None]:
    """Switches culling on or off, wherever the light is."""
    return lambda on: monkeypatch.setattr(shadow_maps, "reaches_into", lambda *_: not on)


def same_maps_without_culling(
    scene: ss.Scene, camera: ss.Camera, culling: Callable[[bool], None], share: float = EDGE_ON_SHARE
) -> set[int]:
    """Checks that culling changes at most this share of the texels, by little, and returns the faces that were drawn.

    Some triangles at a silhouette are narrower than the fraction of a texel that rasterisers snap vertices to, and may
    be turned over by it: there the depth changes by as little.
    """
    culling(False)
    plain, plain_depths, _ = rendered(scene, camera)
    culling(True)
    culled, culled_depths, faces = rendered(scene, camera)
    assert (plain_depths > 0.0).any()
    assert stage.same_bits(culled.visibility, plain.visibility)
    assert np.array_equal(culled_depths > 0.0, plain_depths > 0.0), "every texel is covered as before"
    assert (culled_depths.view(np.uint32) != plain_depths.view(np.uint32)).mean() <= share
    np.testing.assert_allclose(culled_depths, plain_depths, rtol=EDGE_ON_CLOSENESS)
    return faces


@pytest.mark.parametrize("kind", list(stage.LIGHTS))
def test_culling_changes_no_visibility(kind: str, culling: Callable[[bool], None]) -> None:
    same_maps_without_culling(scene(stage.LIGHTS[kind]), stage.CAMERA, culling)


def test_boxes_lose_no_bit_on_any_face(culling: Callable[[bool], None]) -> None:
    """Every face has the same handedness: none is drawn with the solids' far sides."""
    faces = set()
    for corner in (1.0, -1.0):
        camera = ss.Camera((2.2 * corner, 2.0 * corner, 2.3 * corner), (0.0, 0.0, 0.0), 100.0)
        faces |= same_maps_without_culling(surrounded(), camera, culling, share=0.0)
    assert faces == set(range(shadow_maps.FACES))


def test_the_wrong_side_would_be_seen(culling: Callable[[bool], None]) -> None:
    """The tests above can fail: with the solids inside out, the maps differ."""
    inside_out = scene(stage.RECT)
    culling(False)
    _, plain, _ = rendered(inside_out)
    culling(True)
    for node in inside_out.nodes[2:5]:
        node.mesh.triangles[:] = node.mesh.triangles[:, ::-1].copy()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("softshadows.scene.geometry.is_solid", lambda mesh: mesh.material.alpha_cutoff is None)
        _, culled, _ = rendered(inside_out)
    assert not stage.same_bits(culled, plain)


BOX_LOW, BOX_HIGH = (-0.5, 0.5, -0.5), (0.5, 1.5, 0.5)
INSIDE = {
    "point": ss.PointLight((0.0, 1.0, 0.0), stage.WHITE),
    "disk": ss.DiskLight((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 0.3, stage.WHITE),
    "rect": ss.RectLight((0.0, 1.0, 0.0), (0.0, 0.0, 0.1), 0.3, 0.8, stage.WHITE),
    "a hair above the lower side": ss.PointLight((0.0, 0.5 + 1e-6, 0.0), stage.WHITE),
}


@pytest.mark.parametrize("kind", list(INSIDE))
def test_a_light_inside_a_solid_is_hidden_by_it(kind: str, culling: Callable[[bool], None]) -> None:
    boxed = ss.Scene([stage.floor(), stage.box(BOX_LOW, BOX_HIGH)], [INSIDE[kind]])
    frame, _, _ = rendered(boxed)
    on_floor = frame.surface & (frame.position[..., 1] < 1e-3)
    assert on_floor.sum() > 500
    if kind == "a hair above the lower side":  # nearer than the near plane, which cuts the box open: as without culling
        culling(False)
        assert stage.same_bits(frame.visibility, rendered(boxed)[0].visibility)
        return
    assert (frame.visibility[0][on_floor] == 0.0).all()
    culling(True)
    assert (rendered(boxed)[0].visibility[0][on_floor] > 0.0).any(), "culled, it would shine through"


@pytest.mark.parametrize("kind", ["point", "disk", "rect", "line"])
def test_lights_that_reach_into_a_solids_box_are_told_apart(kind: str) -> None:
    light, box = stage.LIGHTS[kind], np.array([[(-5.0, 3.0, -5.0), (-1.0, 5.0, 5.0)]])
    sides = np.array([extent * axis[0] for extent, axis in zip(light.half_extent, light.axes, strict=False)])
    reach = np.hypot(*sides) if kind == "disk" else np.abs(sides).sum()  # from its centre along x
    gap = light.center[0] - reach - box[0, 1, 0]
    assert gap > 0.0
    for nudge, expected in ((-1e-6, False), (1e-6, True)):
        assert shadow_maps.reaches_into(box, light, gap + nudge) == expected
    assert not shadow_maps.reaches_into(box[:0], light, 1e9)


def test_a_directional_light_is_outside_everything() -> None:
    box = np.array([[(-1e3, -1e3, -1e3), (1e3, 1e3, 1e3)]])
    assert not shadow_maps.reaches_into(box, stage.LIGHTS["directional"], 1.0)


def test_a_node_that_moves_over_the_light_is_no_longer_culled() -> None:
    """Between frames of one renderer: the decision follows nodes and lights."""
    above, around = stage.moved(stage.box(BOX_LOW, BOX_HIGH), (0.0, -0.4, 0.0)), stage.box(BOX_LOW, BOX_HIGH)
    light = ss.PointLight((0.0, 1.4, 0.0), stage.WHITE)
    moving = ss.Scene([stage.floor(), above], [light])
    technique = ss.techniques.Uniform(grid=GRID, resolution=256)
    with ss.Renderer(moving, technique=technique, size=stage.SIZE) as renderer:
        for node, hidden in ((above, False), (around, True), (above, False)):
            moving.nodes[1] = ss.Node(above.mesh, node.transform)
            frame = renderer.render(stage.CAMERA)
            on_floor = frame.surface & (frame.position[..., 1] < 1e-3)
            assert (frame.visibility[0][on_floor] == 0.0).all() == hidden
        moving.lights = [dataclasses.replace(light, position=(0.0, 0.6, 0.0))]
        assert (renderer.render(stage.CAMERA).visibility[0][on_floor] == 0.0).all()
        flat = above.transform.copy()
        flat[1, 1] = 0.0
        moving.nodes[1] = ss.Node(above.mesh, flat)
        flattened = renderer.render(stage.CAMERA)
    assert stage.same_bits(flattened.visibility, stage.render(moving, technique).visibility)
