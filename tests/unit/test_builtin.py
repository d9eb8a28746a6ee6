"""The built-in scenes: closed solids, outward winding, the sizes that the papers state, the same scene every time."""

from __future__ import annotations

import numpy as np
import pytest

from softshadows.errors import SceneError
from softshadows.scene import builtin
from softshadows.scene.builtin import shapes
from softshadows.scene.geometry import flatten
from softshadows.scene.model import Mesh

OPEN_MESHES = {"floor", "blocker", "leaves"}  # a floor, cards without thickness, alpha-masked cards

SOLIDS = {
    "box": shapes.box((0, 0, 0), (1, 2, 3)),
    "sphere": shapes.sphere(762),
    "small sphere": shapes.sphere(12),
    "torus": shapes.torus(1.0, 0.25),
    "rounded box": shapes.rounded_box((1.0, 0.5, 0.7), 0.1),
    "tube": shapes.tube((0, 0, 0), (1, 1, 0), 0.1),
    "cone": shapes.lathe([(1, 0), (0, 1)], 24),
    "panel": shapes.panel([0, 1, 2, 3], [0, 1, 2, 3], [[1, 1, 1], [1, 0, 1], [1, 1, 1]], (0.0, 0.1)),
    "frame": shapes.frame((1, 2), (2, 3), (0, 1)),
}


def welded(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(positions, triangles) with the vertices that normals and texture coordinates split joined again."""
    positions, index = np.unique(mesh.positions, axis=0, return_inverse=True)
    return positions, index.reshape(-1)[mesh.triangles]


def assert_closed(triangles: np.ndarray) -> None:
    """Every directed edge is met by as many edges the other way: no holes, and neighbours agree on the outside."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    count = edges.max() + 1
    forward, backward = np.sort(edges[:, 0] * count + edges[:, 1]), np.sort(edges[:, 1] * count + edges[:, 0])
    assert np.array_equal(forward, backward)


@pytest.fixture(scope="module", params=list(builtin.SCENES))
def name(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.mark.parametrize("solid", SOLIDS)
def test_primitives_are_two_manifolds_that_look_outward(solid: str) -> None:
    positions, triangles = SOLIDS[solid]
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert_closed(triangles)
    assert shapes.signed_volume(positions, triangles) > 0.0


@pytest.mark.parametrize(
    ("solid", "volume"),
    [("box", 6.0), ("panel", 0.8), ("frame", 16.0), ("torus", 2 * np.pi**2 * 0.25**2)],
)
def test_primitives_have_their_volume(solid: str, volume: float) -> None:
    assert shapes.signed_volume(*SOLIDS[solid]) == pytest.approx(volume, rel=0.03)


@pytest.mark.parametrize("triangles", [12, 20, 80, 320, 762, 3048])
def test_spheres_have_exactly_the_triangles_asked_for(triangles: int) -> None:
    solid = shapes.sphere(triangles)
    assert len(solid.triangles) == triangles
    assert len(solid.positions) == triangles // 2 + 2
    np.testing.assert_allclose(np.linalg.norm(solid.positions, axis=1), 1.0, atol=1e-12)


def test_normals_are_split_at_sharp_edges_and_smooth_elsewhere() -> None:
    box = shapes.mesh(shapes.box((0, 0, 0), (1, 1, 1)), builtin.SCENES["blocker"]().nodes[0].mesh.material)
    assert len(box.positions) == 24
    ball = shapes.mesh(shapes.sphere(762), box.material)
    assert len(ball.positions) == 383
    assert ball.normals is not None
    assert np.einsum("ij,ij->i", ball.normals, ball.positions).min() > 0.99


def test_every_scene_has_light_camera_description_and_finite_geometry(name: str) -> None:
    scene = builtin.make(name)
    geometry = flatten(scene)
    assert scene.name == name
    assert scene.lights
    assert scene.camera is not None
    assert builtin.describe(name).endswith(".")
    assert np.isfinite(geometry.positions).all()
    assert np.isfinite(geometry.normals).all()
    assert (np.linalg.norm(geometry.face_normals, axis=1) > 0.5).all(), "degenerate triangles"


def test_every_scene_is_the_same_each_time(name: str) -> None:
    first, second = flatten(builtin.make(name)), flatten(builtin.make(name))
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.triangles, second.triangles)
    assert np.array_equal(first.texcoords, second.texcoords)


def test_scenes_share_no_materials(name: str) -> None:
    """Repainting one scene must not repaint the next."""
    first, second = builtin.make(name), builtin.make(name)
    materials = [{id(node.mesh.material) for node in scene.nodes} for scene in (first, second)]
    assert not materials[0] & materials[1]


def test_every_solid_part_is_closed_and_wound_outward(name: str) -> None:
    for mesh in {id(node.mesh): node.mesh for node in builtin.make(name).nodes}.values():
        if mesh.name not in OPEN_MESHES:
            positions, triangles = welded(mesh)
            assert_closed(triangles)
            assert shapes.signed_volume(positions, triangles) > 0.0, mesh.name


def test_shading_normals_agree_with_the_winding(name: str) -> None:
    geometry = flatten(builtin.make(name))
    shading = geometry.normals[geometry.triangles]
    facing = np.einsum("tci,ti->tc", shading, geometry.face_normals)
    has_normals = np.linalg.norm(shading, axis=2) > 0.5
    masked = np.arange(len(facing)) >= geometry.opaque_count
    assert facing[has_normals & ~masked[:, None]].min(initial=1.0) > 0.0


@pytest.mark.parametrize("count", [1_000, 10_000, 100_000, 1_000_000])
def test_field_has_about_the_triangles_asked_for(count: int) -> None:
    assert builtin.field(count).triangle_count == pytest.approx(count, rel=0.2)


def test_sphere_cube_has_the_papers_spheres() -> None:
    scene = builtin.sphere_cube(3)
    spheres = [node.mesh for node in scene.nodes if node.mesh.name == "sphere"]
    assert len(spheres) == 27
    assert len(spheres[0].triangles) == 762
    assert len({id(mesh) for mesh in spheres}) == 1, "the spheres share one mesh"


@pytest.mark.parametrize("name", ["atrium", "room"])
def test_the_light_hangs_clear_of_the_walls(name: str) -> None:
    """Its four corners see the middle of the picture, so no light sample starts inside the masonry."""
    scene = builtin.make(name)
    light, camera = scene.lights[0], scene.camera
    assert camera is not None
    corners = light.points(np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1]))
    triangle = flatten(scene)
    a, b, c = triangle.positions.astype(np.float64)[triangle.triangles].transpose(1, 0, 2)
    target = np.array({"atrium": (3.0, -0.4, 1.0), "room": (-0.9, 0.9, 0.3)}[name])
    for corner in corners:
        ray = target - corner  # Möller and Trumbore 1997, all triangles at once
        p = np.cross(ray, c - a)
        determinant = np.einsum("ij,ij->i", b - a, p)
        safe = np.where(np.abs(determinant) < 1e-12, np.inf, determinant)
        u = np.einsum("ij,ij->i", corner - a, p) / safe
        q = np.cross(corner - a, b - a)
        v, t = q @ ray / safe, np.einsum("ij,ij->i", c - a, q) / safe
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1) & np.isfinite(safe)
        assert not hit.any()


def test_atrium_is_large() -> None:
    assert 100_000 < builtin.atrium().triangle_count < 400_000


def test_blocker_follows_its_parameters() -> None:
    scene = builtin.blocker(
        light_height=8.0, height=2.0, light_half=(0.5, 0.25), occluders=[(-1, 0, -2, 2), (1, 3, 0, 1)]
    )
    light = scene.lights[0]
    assert tuple(light.center) == (0.0, 8.0, 0.0)
    assert light.half_extent == (0.5, 0.25)
    np.testing.assert_allclose(light.axes[0], (1, 0, 0))
    cards = [node for node in scene.nodes if node.name == "blocker"]
    assert len(cards) == 2
    low, high = flatten(scene).positions[4:8].min(axis=0), flatten(scene).positions[4:8].max(axis=0)
    np.testing.assert_allclose([low, high], [(-1, 2, -2), (0, 2, 2)])


def test_leaves_are_masked_cards() -> None:
    scene = builtin.leaves()
    (card,) = [node.mesh for node in scene.nodes if node.mesh.material.alpha_cutoff is not None]
    assert card.texcoords is not None
    assert card.material.base_color_texture is not None
    alpha = card.material.base_color_texture.pixels[..., 3]
    assert 0.2 < (alpha > 127).mean() < 0.8


@pytest.mark.parametrize(
    "call",
    [
        lambda: builtin.blocker(height=10.0),
        lambda: builtin.sphere_cube(0),
        lambda: builtin.field(10),
        lambda: builtin.fence(bar_width=0.0),
        lambda: builtin.make("sponza"),
    ],
)
def test_bad_parameters_are_named(call) -> None:
    with pytest.raises(SceneError, match=r"height|count|bar_width|atrium"):
        call()
