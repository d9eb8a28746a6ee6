"""light_space.wgsl against float64 numpy: cube faces, windows, inverse depth, the receiver's plane."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import wgpu

from softshadows.gpu.compose import compose, shader_module
from softshadows.gpu.device import acquire
from softshadows.gpu.layout import pack
from softshadows.lights.record import light_record
from softshadows.scene.lights import DirectionalLight, RectLight
from softshadows.visibility.maps.structs import MapSettings

COUNT = 500
RELATIVE = 2e-6
NEAR, FAR = 0.01, 40.0
RESULTS = 5

KERNEL = """
//#include "visibility/maps/light_space.wgsl"
@group(0) @binding(0) var<storage, read_write> result: array<vec4f>;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> maps: MapSettings;
@group(0) @binding(3) var<storage, read> cases: array<vec4f>;  // vector; normal, plane offset; position, texel extent

@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let vector = cases[3u * id.x].xyz;
    let plane = cases[3u * id.x + 1u];
    let window = cases[3u * id.x + 2u];
    let ls = to_light_space(light, vector);
    let face = face_of(ls);
    let point = face_coordinates(face, ls);
    let base = 5u * id.x;
    result[base] = vec4f(ls, f32(face));
    result[base + 1u] = vec4f(point, inverse_depth_of(point.z));
    result[base + 2u] = vec4f(window_position(point), inverse_depth_of_extent(0.25, window.z), 0.0);
    result[base + 3u] = vec4f(
        plane_inverse_depth(plane.xyz, plane.w, window.xy),
        inverse_depth_per_texel(plane.xyz, plane.w, window.zw),
        0.0,
        0.0,
    );
    result[base + 4u] = vec4f(face_coordinates(id.x % FACES, ls), f32(id.x % FACES));
}
"""

LIGHTS = {
    "rect": RectLight((1.0, 2.0, 3.0), (0.2, -0.7, 0.4), 1.0, 2.0, (1.0, 1.0, 1.0)),
    "directional": DirectionalLight((0.3, -1.0, 0.2), (1.0, 1.0, 1.0)),
}
lights = pytest.mark.parametrize("kind", list(LIGHTS))

AXES = np.array([[0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], np.float64)
"""The faces' axes in light space: front first, back last."""


def cases() -> npt.NDArray[np.float32]:
    """(COUNT, 3, 4): vectors of all lengths and directions, the six axes first; planes before the light; windows."""
    random = np.random.default_rng(4)
    vectors = random.normal(size=(COUNT, 3)) * 10.0 ** random.uniform(-1.0, 1.0, (COUNT, 1))
    normals = random.normal(size=(COUNT, 3))
    normals[:, 2] = -0.3 - np.abs(normals[:, 2])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offset = -random.uniform(0.5, 5.0, (COUNT, 1))
    window = np.hstack([random.uniform(-1.0, 1.0, (COUNT, 2)), random.uniform(1e-3, 1e-2, (COUNT, 2))])
    return np.stack([np.pad(vectors, ((0, 0), (0, 1))), np.hstack([normals, offset]), window], axis=1).astype(
        np.float32
    )


def maps() -> MapSettings:
    """With the depths that light_space.wgsl reads."""
    others = dict.fromkeys((field.name for field in fields(MapSettings)), 0)
    return MapSettings(**{**others, "near": NEAR, "far": FAR})  # type: ignore[arg-type]


def run(kind: str, tmp_path: Path) -> npt.NDArray[np.float64]:
    """(COUNT, RESULTS, 4)."""
    shader = tmp_path / "light_space_test.wgsl"
    shader.write_text(KERNEL, encoding="utf-8")
    device, usage = acquire().device, wgpu.BufferUsage
    size = 16 * RESULTS * COUNT
    buffers = [
        device.create_buffer(size=size, usage=usage.STORAGE | usage.COPY_SRC),
        device.create_buffer_with_data(data=pack(light_record(LIGHTS[kind], 0)), usage=usage.UNIFORM),
        device.create_buffer_with_data(data=pack(maps()), usage=usage.UNIFORM),
        device.create_buffer_with_data(data=cases().tobytes(), usage=usage.STORAGE),
    ]
    pipeline = device.create_compute_pipeline(
        layout="auto",
        compute={"module": shader_module(device, compose(shader), shader.name), "entry_point": "cs_test"},
    )
    entries = [{"binding": i, "resource": {"buffer": buffer}} for i, buffer in enumerate(buffers)]
    bindings = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(COUNT)
    compute.end()
    device.queue.submit([encoder.finish()])
    data = np.frombuffer(device.queue.read_buffer(buffers[0]), np.float32)
    return data.reshape(COUNT, RESULTS, 4).astype(np.float64)


@lights
def test_light_space_is_the_lights_frame(kind: str, tmp_path: Path) -> None:
    vectors = cases()[:, 0, :3].astype(np.float64)
    expected = vectors @ LIGHTS[kind].axes.T
    scale = np.linalg.norm(vectors, axis=1, keepdims=True)
    np.testing.assert_allclose(run(kind, tmp_path)[:, 0, :3] / scale, expected / scale, atol=RELATIVE)


def test_a_direction_goes_through_the_face_whose_axis_it_follows_most(tmp_path: Path) -> None:
    result = run("rect", tmp_path)
    along, face = result[:, 0, :3], result[:, 0, 3].astype(int)
    assert set(face) == set(range(6))
    assert np.array_equal(face, (along @ AXES.T).argmax(axis=1))
    point = result[:, 1, :3]
    np.testing.assert_allclose(point[:, 2], (along @ AXES.T).max(axis=1), rtol=RELATIVE)
    assert (np.abs(point[:, :2]) <= point[:, 2:3]).all(), "faces meet at 45 degrees"


def test_face_coordinates_are_a_permutation_with_depth_along_the_axis(tmp_path: Path) -> None:
    result = run("rect", tmp_path)
    along, point, face = result[:, 0, :3], result[:, 4, :3], result[:, 4, 3].astype(int)
    np.testing.assert_array_equal(point[:, 2], np.einsum("ij,ij->i", along, AXES[face]))
    np.testing.assert_array_equal(np.sort(np.abs(point), axis=1), np.sort(np.abs(along), axis=1))


def test_windows_are_tangents_and_inverse_depth_the_reciprocal_depth(tmp_path: Path) -> None:
    result = run("rect", tmp_path)
    point = result[:, 1, :3]
    np.testing.assert_allclose(result[:, 2, :2], point[:, :2] / point[:, 2:3], rtol=RELATIVE, atol=1e-7)
    np.testing.assert_allclose(result[:, 1, 3], 1.0 / point[:, 2], rtol=RELATIVE)
    np.testing.assert_allclose(result[:, 2, 2], 0.25 * cases()[:, 2, 2], rtol=RELATIVE)


def test_a_directional_light_has_one_face_in_metres(tmp_path: Path) -> None:
    result = run("directional", tmp_path)
    along, point = result[:, 0, :3], result[:, 1, :3]
    assert (result[:, 0, 3] == 0.0).all()
    np.testing.assert_array_equal(point, along * [1.0, 1.0, -1.0])
    np.testing.assert_array_equal(result[:, 2, :2], point[:, :2])
    np.testing.assert_allclose(result[:, 1, 3], (FAR - point[:, 2]) / (FAR - NEAR), rtol=RELATIVE, atol=1e-6)
    np.testing.assert_allclose(result[:, 2, 2], cases()[:, 2, 2] / (FAR - NEAR), rtol=RELATIVE)


@lights
def test_a_planes_inverse_depth_is_that_of_the_ray_that_meets_it(kind: str, tmp_path: Path) -> None:
    """By intersection in float64: a ray from the origin through the window's point, or parallel to the axis."""
    result = run(kind, tmp_path)[:, 3, :2]
    data = cases().astype(np.float64)
    normal, offset, position, texel = data[:, 1, :3], data[:, 1, 3], data[:, 2, :2], data[:, 2, 2:]

    def inverse_depth(at: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        if kind == "directional":
            depth = (offset - np.einsum("ij,ij->i", normal[:, :2], at)) / normal[:, 2]
            return (FAR - depth) / (FAR - NEAR)
        direction = np.column_stack([at, np.ones(COUNT)])
        return np.einsum("ij,ij->i", normal, direction) / offset  # 1 / depth where offset = normal · direction depth

    np.testing.assert_allclose(result[:, 0], inverse_depth(position), rtol=1e-5, atol=1e-6)
    steps = [np.abs(inverse_depth(position + texel * axis) - inverse_depth(position)) for axis in np.eye(2)]
    np.testing.assert_allclose(result[:, 1], sum(steps), rtol=1e-4, atol=1e-7)
