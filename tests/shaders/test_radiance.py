"""The WGSL of lights against float64 numpy: irradiance by quadrature, highlights by integrating GGX."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
import wgpu

from softshadows.gpu.compose import PACKAGE, compose
from softshadows.gpu.layout import pack
from softshadows.lights.record import KINDS, light_record, specular_tables
from softshadows.scene.lights import (
    LIGHT_CLASSES,
    DirectionalLight,
    DiskLight,
    LineLight,
    PointLight,
    RectLight,
    SpotLight,
)

WHITE = (1.0, 1.0, 1.0)
RELATIVE = 1e-5  # of irradiance, except where less than
ABSOLUTE = 3e-7  # of the π that a light all around gives
SPECULAR = {5: 0.006, 45: 0.006, 70: 0.02, 80: 0.05}
"""View angle in degrees to the largest error measured, rounded up, where a mirror would show radiance 1."""
LINE_SPECULAR = {5: 0.006, 45: 0.006, 70: 0.03, 80: 0.15}

LIGHT_KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var<storage, read> points: array<vec4f>;  // position, then normal
@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let i = id.x;
    let position = points[2u * i].xyz;
    let normal = points[2u * i + 1u].xyz;
    let above = fraction_above_horizon(lights[i], position, normal);
    result[i] = vec4f(diffuse_irradiance(lights[i], position, normal), above, 0.0, 0.0);
}
"""

SURFACE_KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var<storage, read> surfaces: array<vec4f>;  // view and roughness, base color and metallic
@group(0) @binding(3) var ltc_matrix: texture_2d<f32>;
@group(0) @binding(4) var ltc_albedo: texture_2d<f32>;
@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let i = id.x;
    let a = surfaces[2u * i];
    let b = surfaces[2u * i + 1u];
    let up = vec3f(0.0, 1.0, 0.0);
    let surface = Surface(vec3f(0.0), up, a.xyz, b.rgb, b.a, a.w);
    let lobes = shading_lobes(surface, ltc_matrix, ltc_albedo);
    result[i] = vec4f(unshadowed_radiance(lights[i], surface, lobes), 0.0);
}
"""

PACKING_KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<storage, read> values: array<vec4f>;
@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let value = values[id.x].xyz;
    result[3u * id.x] = vec4f(unpack_normal(pack_normal(value)), 0.0);
    result[3u * id.x + 1u] = vec4f(unpack_rgb9e5(pack_rgb9e5(value)), 0.0);
    result[3u * id.x + 2u] = vec4f(srgb_to_linear(linear_to_srgb(value)), linear_to_srgb(value).x);
}
"""


@cache
def device() -> wgpu.GPUDevice:
    return wgpu.gpu.request_adapter_sync().request_device_sync()


@cache
def pipeline(library: str, kernel: str) -> wgpu.GPUComputePipeline:
    code = compose(PACKAGE / library).text + kernel
    module = device().create_shader_module(code=code)
    return device().create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "cs_test"})


@cache
def table_textures() -> list[wgpu.GPUTexture]:
    textures = []
    for table, format in zip(specular_tables(), ("rgba32float", "rg32float"), strict=True):
        height, width, _ = table.shape
        usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
        texture = device().create_texture(size=(width, height, 1), format=format, usage=usage)
        layout = {"bytes_per_row": table.strides[0], "rows_per_image": height}
        device().queue.write_texture({"texture": texture}, table, layout, (width, height, 1))
        textures.append(texture)
    return textures


def run(
    library: str, kernel: str, inputs: list[bytes], count: int, results: int = 1, textures: tuple = ()
) -> np.ndarray:
    """(count × results, 4) float64: the kernel on one workgroup per item."""
    usage = wgpu.BufferUsage.STORAGE
    output = device().create_buffer(size=16 * count * results, usage=usage | wgpu.BufferUsage.COPY_SRC)
    buffers = [output] + [device().create_buffer_with_data(data=data, usage=usage) for data in inputs]
    resources = [{"buffer": buffer} for buffer in buffers] + [texture.create_view() for texture in textures]
    compiled = pipeline(library, kernel)
    entries = [{"binding": index, "resource": resource} for index, resource in enumerate(resources)]
    group = device().create_bind_group(layout=compiled.get_bind_group_layout(0), entries=entries)
    encoder = device().create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(compiled)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(count)
    compute.end()
    device().queue.submit([encoder.finish()])
    return np.frombuffer(device().queue.read_buffer(output), np.float32).reshape(-1, 4).astype(np.float64)


def irradiance(lights: list, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(n, 2) float64: diffuse irradiance per unit emission, and the light's share above the horizon."""
    rows = np.zeros((len(lights), 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 1, :3] = points, normals
    records = pack(*map(light_record, lights))
    return run("lights/radiance.wgsl", LIGHT_KERNEL, [records, rows.tobytes()], len(lights))[:, :2]


def radiance(lights: list, views: np.ndarray, roughness: np.ndarray, color=WHITE, metallic: float = 1.0) -> np.ndarray:
    """(n, 3) float64 for surfaces at the origin that face +y."""
    rows = np.zeros((len(lights), 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 0, 3], rows[:, 1, :3], rows[:, 1, 3] = views, roughness, color, metallic
    inputs = [pack(*map(light_record, lights)), rows.tobytes()]
    return run("lights/radiance.wgsl", SURFACE_KERNEL, inputs, len(lights), textures=tuple(table_textures()))[:, :3]


def test_every_kind_of_light_is_told_from_the_others() -> None:
    """A kind without its case in radiance.wgsl would be dark."""
    assert len(set(KINDS.values())) == len(LIGHT_CLASSES)
    text = (PACKAGE / "lights/radiance.wgsl").read_text(encoding="utf-8")
    for function in ("irradiance", "specular"):
        cases = re.findall(rf"light\.kind == (\w+); .*\n        {function} = (\w+)_{function}\(", text)
        assert sorted(cases) == sorted((kind.upper(), kind) for kind in LIGHT_CLASSES)


# -- The reference -----------------------------------------------------------------------------------------------------


@cache
def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on 0..1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * nodes + 0.5, 0.5 * weights


def clip(corners: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """The part of a convex polygon where the height is positive."""
    kept = []
    for i in range(len(corners)):
        j = (i + 1) % len(corners)
        if heights[i] > 0.0:
            kept.append(corners[i])
        if (heights[i] > 0.0) != (heights[j] > 0.0):
            t = heights[i] / (heights[i] - heights[j])
            kept.append(corners[i] + t * (corners[j] - corners[i]))
    return np.array(kept)


def surface_nodes(light, point, normal, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points on the part of a rectangle or disk above the receiver's plane, (n, 3), and their areas (n,)."""
    right, up, _ = light.axes
    a, b = light.half_extent
    u, wu = (
        part.ravel() for part in np.broadcast_arrays(*[axis[:, None] for axis in gauss(count)], np.ones((1, count)))[:2]
    )
    v, wv = (
        part.ravel() for part in np.broadcast_arrays(*[axis[None, :] for axis in gauss(count)], np.ones((count, 1)))[:2]
    )
    if light.kind == "disk":
        slope = np.array([a * (right @ normal), a * (up @ normal)])
        drop = np.hypot(*slope)
        across = slope / drop if drop > 0.0 else np.array([1.0, 0.0])
        angle = np.arccos(np.clip(-(light.center - point) @ normal / drop, -1.0, 1.0)) if drop > 0.0 else np.pi
        theta = u * angle
        x, y = np.cos(theta), np.sin(theta) * (2.0 * v - 1.0)
        local = np.outer(x, across) + np.outer(y, [-across[1], across[0]])
        return light.center + a * local @ np.stack([right, up]), a * a * angle * 2.0 * np.sin(theta) ** 2 * wu * wv
    corners = light.center + np.array([[-a, -b], [a, -b], [a, b], [-a, b]]) @ np.stack([right, up])
    corners = clip(corners, (corners - point) @ normal)
    nodes, areas = [np.empty((0, 3))], [np.empty(0)]
    for i in range(1, len(corners) - 1):
        one, two = corners[i] - corners[0], corners[i + 1] - corners[i]
        nodes.append(corners[0] + u[:, None] * (one + v[:, None] * two))
        areas.append(np.linalg.norm(np.cross(one, two)) * u * wu * wv)
    return np.concatenate(nodes), np.concatenate(areas)


def solid_angles(light, point, normal, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions to the light (n, 3), and their solid angles times emission (n,), by Gauss-Legendre quadrature."""
    if light.kind == "line":
        ends = np.array([light.start, light.end]) - point
        heights = ends @ normal
        if heights.max() <= 0.0:
            return np.empty((0, 3)), np.empty(0)
        if heights.min() < 0.0:
            ends[heights.argmin()] = ends[0] + heights[0] / (heights[0] - heights[1]) * (ends[1] - ends[0])
        u, weights = gauss(count * count)
        to_light = ends[0] + u[:, None] * (ends[1] - ends[0])
        distance = np.linalg.norm(to_light, axis=1)
        axis = ends[1] - ends[0]
        sine = np.linalg.norm(np.cross(to_light, axis), axis=1) / distance
        return to_light / distance[:, None], weights * sine / distance**2
    nodes, areas = surface_nodes(light, point, normal, count)
    to_light = nodes - point
    distance = np.linalg.norm(to_light, axis=1)
    direction = to_light / distance[:, None]
    facing = direction @ light.axes[2]
    facing = np.maximum(facing, 0.0) if light.one_sided else np.abs(facing)
    return direction, areas * facing / distance**2


def expected_irradiance(light, point, normal, count: int = 48) -> float:
    direction, angle = solid_angles(light, point, normal, count)
    return float(angle @ (direction @ normal))


def expected_specular(light, view, roughness: float, count: int = 48) -> float:
    """The light's radiance in a GGX mirror of Fresnel 1 at the origin that faces +y."""
    up = np.array([0.0, 1.0, 0.0])
    direction, angle = solid_angles(light, np.zeros(3), up, count)
    alpha = roughness**2
    half = direction + view
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    distribution = alpha**2 / (np.pi * (half[:, 1] ** 2 * (alpha**2 - 1.0) + 1.0) ** 2)
    masking = [0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / cosine**2 - 1.0)) - 1.0) for cosine in (view[1], direction[:, 1])]
    return float(angle @ (distribution / (4.0 * view[1] * (1.0 + masking[0] + masking[1]))))


# -- Irradiance --------------------------------------------------------------------------------------------------------


def random_unit(random: np.random.Generator, count: int) -> np.ndarray:
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def random_light(random: np.random.Generator, kind: str, two_sided: bool):
    a, b = random.uniform(-1.0, 1.0, (2, 3))
    if kind == "rect":
        return RectLight(a, b, random.uniform(0.1, 2.0), random.uniform(0.1, 2.0), WHITE, two_sided)
    if kind == "disk":
        return DiskLight(a, b, random.uniform(0.1, 1.0), WHITE, two_sided)
    return LineLight(a, b, WHITE)


@pytest.mark.parametrize(
    ("kind", "two_sided"), [("rect", False), ("rect", True), ("disk", False), ("disk", True), ("line", True)]
)
def test_irradiance_equals_quadrature_at_random_receivers(kind: str, two_sided: bool) -> None:
    random = np.random.default_rng(7)
    count = 100
    lights = [random_light(random, kind, two_sided) for _ in range(count)]
    points = np.float32(random_unit(random, count) * random.uniform(1.6, 6.0, (count, 1))).astype(np.float64)
    normals = random_unit(random, count)
    found = irradiance(lights, points, normals)[:, 0]
    expected = np.array([expected_irradiance(*case) for case in zip(lights, points, normals, strict=True)])
    assert np.count_nonzero(expected) > count / 5
    np.testing.assert_allclose(found, expected, rtol=RELATIVE, atol=ABSOLUTE)


LIGHT_AT_WALL = {  # a light one metre above the origin, cut in half by a wall through its centre, and just touching one
    "rect": RectLight((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 1.0, 0.6, WHITE),
    "disk": DiskLight((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 0.5, WHITE),
    "line": LineLight((-0.5, 1.0, 0.0), (0.5, 1.0, 0.0), WHITE),
}


@pytest.mark.parametrize("kind", LIGHT_AT_WALL)
@pytest.mark.parametrize(("wall_x", "share"), [(0.0, 0.5), (-0.5, 1.0), (0.5, 0.0)])
def test_a_wall_receives_only_from_the_part_of_the_light_before_it(kind: str, wall_x: float, share: float) -> None:
    light, point, normal = LIGHT_AT_WALL[kind], np.array([wall_x, 0.25, 0.125]), np.array([1.0, 0.0, 0.0])
    found, above = irradiance([light], point, normal)[0]
    np.testing.assert_allclose(found, expected_irradiance(light, point, normal), rtol=RELATIVE, atol=ABSOLUTE)
    assert above == pytest.approx(share, abs=1e-6)


def test_share_above_the_horizon_equals_the_clipped_area() -> None:
    random = np.random.default_rng(3)
    lights = [random_light(random, kind, True) for kind in ("rect", "disk") for _ in range(100)]
    points, normals = random.uniform(-1.0, 1.0, (2, 200, 3)).astype(np.float32).astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = irradiance(lights, points, normals)[:, 1]
    for light, point, normal, share in zip(lights, points, normals, found, strict=True):
        area = (np.pi if light.kind == "disk" else 4.0) * light.half_extent[0] * light.half_extent[1]
        assert share == pytest.approx(surface_nodes(light, point, normal, 24)[1].sum() / area, abs=2e-4)


def test_one_sided_lights_are_dark_behind_and_two_sided_ones_are_not() -> None:
    above, up = np.array([0.3, 2.0, 0.1]), np.array([0.0, -1.0, 0.0])
    for make in (lambda sides: RectLight((0, 1, 0), (0, 0, 0), 1.0, 0.6, WHITE, sides),
                 lambda sides: DiskLight((0, 1, 0), (0, 0, 0), 0.5, WHITE, sides)):  # fmt: skip
        dark, lit = irradiance([make(False), make(True)], np.tile(above, (2, 1)), np.tile(up, (2, 1)))[:, 0]
        assert dark == 0.0
        assert lit == pytest.approx(expected_irradiance(make(True), above, up), rel=RELATIVE)


def test_a_line_seen_end_on_and_lights_of_no_size_give_no_light_and_no_nan() -> None:
    lights = [
        LineLight((1, 0, 0), (2, 0, 0), WHITE),  # the receiver lies on its axis
        LineLight((0, 1, 0), (0, 1, 0), WHITE),
        RectLight((0, 1, 0), (0, 0, 0), 0.0, 1.0, WHITE),
        DiskLight((0, 1, 0), (0, 0, 0), 0.0, WHITE),
    ]
    normals = np.tile([0.6, 0.8, 0.0], (4, 1))
    assert np.array_equal(irradiance(lights, np.zeros((4, 3)), normals)[:, 0], np.zeros(4))


def test_receivers_on_the_light_itself_get_a_finite_irradiance() -> None:
    rect, disk, line = LIGHT_AT_WALL.values()
    points = [(0, 1, 0), (0.5, 1, 0), (0.5, 1, 0.3), (0, 1, 0), (0.5, 1, 0), (0.5, 1, 0)]
    found = irradiance([rect, rect, rect, disk, disk, line], np.array(points), np.tile([0.0, 1.0, 0.0], (6, 1)))
    assert np.isfinite(found).all()


def test_a_disk_overhead_has_the_closed_form_of_a_cone() -> None:
    """E = π R² / (R² + h²)."""
    heights = np.array([0.01, 0.1, 1.0, 10.0, 100.0])
    lights = [DiskLight((0, height, 0), (0, 0, 0), 0.5, WHITE) for height in heights]
    found = irradiance(lights, np.zeros((5, 3)), np.tile([0.0, 1.0, 0.0], (5, 1)))[:, 0]
    np.testing.assert_allclose(found, np.pi * 0.25 / (0.25 + heights**2), rtol=RELATIVE)


@pytest.mark.parametrize("angle", [1e-1, 1e-2, 1e-3])
def test_small_lights_keep_digits_in_proportion_to_their_angle(angle: float) -> None:
    random = np.random.default_rng(5)
    lights = [
        make(position, target, size)
        for position, target in zip(random.uniform(-0.1, 0.1, (40, 3)), random_unit(random, 40), strict=True)
        for size in (angle,)
        for make in (
            lambda a, b, s: RectLight(a, b, s, 0.7 * s, WHITE, True),
            lambda a, b, s: DiskLight(a, b, s / 2, WHITE, True),
        )
    ]
    points = np.tile(np.float32([0.6, 0.8, 0.3]), (80, 1)).astype(np.float64)
    normals = np.tile([-0.6, -0.8, 0.0], (80, 1))
    found = irradiance(lights, points, normals)[:, 0]
    # An emitter seen edge on has few digits whatever the method: its angle is narrower than its size.
    expected = np.array([expected_irradiance(*case, 8) for case in zip(lights, points, normals, strict=True)])
    np.testing.assert_allclose(found, expected, rtol=5e-7 / angle, atol=5e-7 * angle)


def test_punctual_lights_follow_their_definitions() -> None:
    point, normal = np.array([0.3, 0.0, 0.2]), np.array([0.0, 1.0, 0.0])
    spot = SpotLight((0, 2, 0), (0, 0, 0), WHITE, inner_angle=5.0, outer_angle=20.0)
    lights = [
        PointLight((0, 2, 0), WHITE),
        spot,
        DirectionalLight((1.0, -1.0, 0.0), WHITE),
        DirectionalLight((0, 1, 0), WHITE),
    ]
    found = irradiance(lights, np.tile(point, (4, 1)), np.tile(normal, (4, 1)))[:, 0]
    distance = np.sqrt(0.3**2 + 0.2**2 + 4.0)
    cosine = 2.0 / distance
    inner, outer = np.cos(np.radians([5.0, 20.0]))
    falloff = ((cosine - outer) / (inner - outer)) ** 2
    np.testing.assert_allclose(
        found, [cosine / distance**2, falloff * cosine / distance**2, np.sqrt(0.5), 0.0], rtol=RELATIVE
    )


# -- Reflection --------------------------------------------------------------------------------------------------------


def view_at(degrees: float) -> np.ndarray:
    return np.array([np.sin(np.radians(degrees)), np.cos(np.radians(degrees)), 0.0])


def lights_around_mirror_direction(kind: str, view: np.ndarray) -> list:
    """Two metres away: in the mirror direction, beside it, large, and well off it."""
    lights = []
    for offset, size in (((0, 0, 0), 1.0), ((0.5, 0.3, 0.4), 1.0), ((0, 0, 0), 2.0), ((0, 0.5, 1.0), 0.5)):
        center = 2.0 * view * (-1, 1, -1) + offset
        if kind == "line":
            half = np.array([0.3, 0.2, 1.0]) * size / 2.0
            lights.append(LineLight(center - half, center + half, WHITE))
        elif kind == "disk":
            lights.append(DiskLight(center, (0, 0, 0), size / 2.0, WHITE))
        else:
            lights.append(RectLight(center, (0, 0, 0), size, 0.7 * size, WHITE))
    return lights


@pytest.mark.parametrize("roughness", [0.3, 0.5, 0.7, 1.0])
@pytest.mark.parametrize(("kind", "tolerance"), [("rect", SPECULAR), ("disk", SPECULAR), ("line", LINE_SPECULAR)])
def test_highlights_are_close_to_ggx_integrated_over_the_light(kind: str, tolerance: dict, roughness: float) -> None:
    for degrees, largest in tolerance.items():
        view = view_at(degrees)
        lights = lights_around_mirror_direction(kind, view)
        found = radiance(lights, np.tile(view, (len(lights), 1)), np.full(len(lights), roughness))[:, 0]
        expected = [expected_specular(light, view, roughness) for light in lights]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=largest)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 80.0])
def test_a_light_all_around_returns_the_albedo_and_never_more(degrees: float) -> None:
    """White furnace. A mirror of Fresnel 1 loses what masking takes; white plastic, diffuse added, loses nothing."""
    view, roughness = view_at(degrees), np.array([0.1, 0.3, 0.6, 1.0])
    sky = [RectLight((0, 1, 0), (0, 0, 0), 1e4, 1e4, WHITE)] * 4
    mirror = radiance(sky, np.tile(view, (4, 1)), roughness)
    plastic = radiance(sky, np.tile(view, (4, 1)), roughness, metallic=0.0)
    np.testing.assert_allclose(mirror[:, 0], [directional_albedo(view, value) for value in roughness], atol=1e-3)
    np.testing.assert_allclose(plastic, 1.0, atol=1e-4)


def directional_albedo(view: np.ndarray, roughness: float) -> float:
    """∫ GGX cos θ_l for Fresnel 1: half vectors distributed as D cos θ_h, at the midpoints of a grid."""
    alpha = roughness**2
    u, v = (axis.ravel() for axis in np.meshgrid((np.arange(800) + 0.5) / 800, (np.arange(400) + 0.5) / 400))
    cosine = np.sqrt((1.0 - u) / (1.0 + (alpha**2 - 1.0) * u))
    sine = np.sqrt(1.0 - cosine**2)
    half = np.stack([sine * np.cos(2.0 * np.pi * v), cosine, sine * np.sin(2.0 * np.pi * v)], axis=1)
    view_half = half @ view
    light_cosine = 2.0 * view_half * cosine - view[1]
    counts = (light_cosine > 0.0) & (view_half > 0.0)
    light_cosine, view_half, cosine = light_cosine[counts], view_half[counts], cosine[counts]
    masking = [0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / value**2 - 1.0)) - 1.0) for value in (view[1], light_cosine)]
    return float(np.sum(view_half / ((1.0 + masking[0] + masking[1]) * view[1] * cosine)) / u.size)


def test_small_lights_reflect_like_the_point_light_they_shrink_to() -> None:
    view, size, along = view_at(40.0), 0.02, np.array([0.0, 0.0, 0.02])
    center = np.array([-1.0, 2.0, 0.4])
    facing = np.linalg.norm(center)
    lights = [
        RectLight(center, (0, 0, 0), size, size, np.full(3, 1.0 / size**2)),
        DiskLight(center, (0, 0, 0), size, np.full(3, 1.0 / (np.pi * size**2))),
        LineLight(center - along, center + along, np.full(3, 0.5 / size / np.sqrt(1.0 - (0.4 / facing) ** 2))),
        PointLight(center, WHITE),
    ]
    for metallic in (0.0, 1.0):
        *areas, point = radiance(lights, np.tile(view, (4, 1)), np.full(4, 0.6), (0.8, 0.5, 0.2), metallic)
        for area in areas:
            np.testing.assert_allclose(area, point, rtol=0.04)  # the fit of the lobe; diffuse alone agrees to 1e-3


# -- Packing -----------------------------------------------------------------------------------------------------------


def unpacked(values: np.ndarray) -> np.ndarray:
    """(n, 3, 4): normal, shared exponent and sRGB after a round trip of (n, 3) values."""
    rows = np.zeros((len(values), 4), np.float32)
    rows[:, :3] = values
    return run("gpu/packing.wgsl", PACKING_KERNEL, [rows.tobytes()], len(values), results=3).reshape(-1, 3, 4)


def test_normals_survive_packing_to_a_hundredth_of_a_degree() -> None:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    normals = np.concatenate([axes, random_unit(np.random.default_rng(1), 500)])
    found = unpacked(normals)[:, 0, :3]
    assert np.degrees(np.linalg.norm(np.cross(found, normals), axis=1)).max() < 0.01
    np.testing.assert_allclose(found[:6], axes, atol=1e-4)


def test_shared_exponent_keeps_nine_bits_of_the_largest_channel() -> None:
    random = np.random.default_rng(2)
    values = random.uniform(0.0, 1.0, (500, 3)) * 2.0 ** random.uniform(-12.0, 16.0, (500, 1))
    values = np.concatenate([values.clip(max=65408.0), [[0.0] * 3, [511.9] * 3, [1.0, 0.0, 65408.0], [1023.6] * 3]])
    found = unpacked(values)[:, 1, :3]
    assert (np.abs(found - values) <= 2.0**-9 * values.max(axis=1, keepdims=True)).all()
    np.testing.assert_array_equal(unpacked(np.array([[1e9, -3.0, 1.0]]))[0, 1, :2], [65408.0, 0.0])


def test_srgb_round_trip_and_known_values() -> None:
    values = np.linspace(0.0, 1.0, 101)[:, None].repeat(3, axis=1)
    found = unpacked(values)[:, 2]
    np.testing.assert_allclose(found[:, :3], values, atol=2e-5)
    encoded = np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1.0 / 2.4) - 0.055)[:, 0]
    np.testing.assert_allclose(found[:, 3], encoded, atol=2e-5)
