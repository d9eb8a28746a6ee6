"""The WGSL of area lights against float64 numpy: irradiance by quadrature, highlights by integrating GGX over the light."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import wgpu

import softshadows
from softshadows.gpu.compose import compose
from softshadows.gpu.layout import pack
from softshadows.passes.lighting.lighting import Light, light_record, specular_tables
from softshadows.scene.lights import (
    DirectionalLight,
    DiskLight,
    LineLight,
    PointLight,
    RectLight,
    SpotLight,
)

SHADERS = Path(softshadows.__file__).parent / "shaders"
WHITE = (1.0, 1.0, 1.0)
RELATIVE = 1e-5  # of irradiance, except where less than
ABSOLUTE = 3e-7  # of the π that a light all around gives

LIGHT_KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var<storage, read> points: array<vec4f>;  // position, then normal
@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let i = id.x;
    let position = points[2u * i].xyz;
    let normal = points[2u * i + 1u].xyz;
    result[i] = vec4f(diffuse_irradiance(lights[i], position, normal), fraction_above_horizon(lights[i], position, normal), 0.0, 0.0);
}
"""

SURFACE_KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var<storage, read> surfaces: array<vec4f>;  // view and roughness, base color and metallic; at 0, facing +y
@group(0) @binding(3) var ltc_matrix: texture_2d<f32>;
@group(0) @binding(4) var ltc_albedo: texture_2d<f32>;
@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let i = id.x;
    let a = surfaces[2u * i];
    let b = surfaces[2u * i + 1u];
    let up = vec3f(0.0, 1.0, 0.0);
    let surface = Surface(vec3f(0.0), up, up, a.xyz, b.rgb, b.a, a.w);
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
    code = compose(SHADERS / library, (Light,)).text + kernel
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


def run(library: str, kernel: str, inputs: list[bytes], count: int, results: int = 1, textures: tuple = ()) -> np.ndarray:
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
    return run("area_light.wgsl", LIGHT_KERNEL, [records, rows.tobytes()], len(lights))[:, :2]


def radiance(lights: list, views: np.ndarray, roughness: np.ndarray, color=WHITE, metallic: float = 1.0) -> np.ndarray:
    """(n, 3) float64 for surfaces at the origin that face +y."""
    rows = np.zeros((len(lights), 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 0, 3], rows[:, 1, :3], rows[:, 1, 3] = views, roughness, color, metallic
    inputs = [pack(*map(light_record, lights)), rows.tobytes()]
    return run("area_light.wgsl", SURFACE_KERNEL, inputs, len(lights), textures=tuple(table_textures()))[:, :3]


# -- The reference ---------------------------------------------------------------------------------------------------------


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
    u, wu = (part.ravel() for part in np.broadcast_arrays(*[axis[:, None] for axis in gauss(count)], np.ones((1, count)))[:2])
    v, wv = (part.ravel() for part in np.broadcast_arrays(*[axis[None, :] for axis in gauss(count)], np.ones((count, 1)))[:2])
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


# -- Irradiance ------------------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(("kind", "two_sided"), [("rect", False), ("rect", True), ("disk", False), ("disk", True), ("line", True)])
def test_irradiance_equals_quadrature_at_random_receivers(kind: str, two_sided: bool) -> None:
    random = np.random.default_rng(7)
    count = 150
    lights = [random_light(random, kind, two_sided) for _ in range(count)]
    points = np.float32(random_unit(random, count) * random.uniform(1.6, 6.0, (count, 1))).astype(np.float64)
    normals = random_unit(random, count)
    found = irradiance(lights, points, normals)[:, 0]
    expected = np.array([expected_irradiance(*case) for case in zip(lights, points, normals, strict=True)])
    assert np.count_nonzero(expected) > count / 5
    np.testing.assert_allclose(found, expected, rtol=RELATIVE, atol=ABSOLUTE)
