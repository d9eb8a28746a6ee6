"""One declaration for both sides: a Struct's dtype has WGSL's offsets, and values survive a trip through a shader."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import wgpu

from softshadows.gpu import scene_buffers, texture_pages
from softshadows.gpu.compose import compose, shader_module
from softshadows.gpu.device import acquire
from softshadows.gpu.layout import F32, I32, U32, Struct, Vec2f, Vec2u, Vec3f, Vec4f, dtype, pack, wgsl
from softshadows.lights.record import Chunk, Light, LightSamples, samples_record
from softshadows.passes.gbuffer.gbuffer import FrameUniforms
from softshadows.visibility import receivers
from softshadows.visibility.maps import structs

ALIGNMENT_AND_SIZE = {
    "f32": (4, 4),
    "u32": (4, 4),
    "i32": (4, 4),
    "vec2f": (8, 8),
    "vec2u": (8, 8),
    "vec3f": (16, 12),
    "vec4f": (16, 16),
}
"""WGSL specification, section 14.4.1."""


class Awkward(Struct):
    a: F32
    b: Vec3f
    c: U32
    d: Vec2f
    e: I32
    f: Vec4f
    g: Vec2u
    h: Vec3f


class Small(Struct):
    a: U32
    b: Vec2f


class Outer(Struct):
    a: U32
    b: Small
    c: F32
    d: Awkward


SHARED = [
    FrameUniforms, Light, scene_buffers.VertexAttributes, scene_buffers.MaterialRecord, texture_pages.TextureRecord,
    Chunk, structs.MapSettings, structs.ShadowView, receivers.ReceiverBox, receivers.OccluderBox,
]  # fmt: skip
ALL = [Awkward, Small, *SHARED]


@pytest.mark.parametrize("struct", ALL, ids=lambda struct: struct.__name__)
def test_offsets_follow_the_rules_of_wgsl(struct: type[Struct]) -> None:
    made = dtype(struct)
    offset, largest = 0, 4
    for line in wgsl(struct).splitlines()[1:-1]:
        name, wgsl_type = line.strip().rstrip(",").split(": ")
        alignment, size = ALIGNMENT_AND_SIZE[wgsl_type]
        offset = (offset + alignment - 1) // alignment * alignment
        assert made.fields is not None
        field_type, field_offset = made.fields[name][:2]
        assert (field_offset, field_type.itemsize) == (offset, size), name
        offset, largest = offset + size, max(largest, alignment)
    assert made.itemsize == (offset + largest - 1) // largest * largest


def test_declaration_reads_as_wgsl() -> None:
    assert wgsl(Small) == "struct Small {\n    a: u32,\n    b: vec2f,\n};\n"


@pytest.mark.parametrize("struct", ALL, ids=lambda struct: struct.__name__)
def test_values_survive_a_trip_through_a_shader(struct: type[Struct], tmp_path: Path) -> None:
    """An array of structs, copied member by member on the GPU."""
    made = dtype(struct)
    values = np.zeros(3, made)
    assert made.names is not None
    for number, name in enumerate(made.names):
        shape = values[name].shape
        values[name] = (np.arange(values[name].size).reshape(shape) + 100 * number + 1).astype(values[name].dtype)
    members = "".join(f"    results[i].{name} = structs[i].{name};\n" for name in made.names)
    shader = tmp_path / "copy.wgsl"
    shader.write_text(
        f"//#struct {struct.__name__}\n"
        f"@group(0) @binding(0) var<storage, read_write> results: array<{struct.__name__}>;\n"
        f"@group(0) @binding(1) var<storage, read> structs: array<{struct.__name__}>;\n"
        "@compute @workgroup_size(1) fn cs_copy(@builtin(workgroup_id) id: vec3u) {\n    let i = id.x;\n"
        f"{members}}}\n",
        encoding="utf-8",
    )
    copied = np.frombuffer(run(shader, values.tobytes(), 3), made)
    for name in made.names:
        np.testing.assert_array_equal(copied[name], values[name])


def run(shader: Path, data: bytes, groups: int) -> bytes:
    device = acquire().device
    usage = wgpu.BufferUsage
    result = device.create_buffer(size=len(data), usage=usage.STORAGE | usage.COPY_SRC)
    source = device.create_buffer_with_data(data=data, usage=usage.STORAGE)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": shader_module(device, compose(shader), shader.name), "entry_point": "cs_copy"}
    )
    entries = [{"binding": i, "resource": {"buffer": buffer}} for i, buffer in enumerate((result, source))]
    bindings = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(groups)
    compute.end()
    device.queue.submit([encoder.finish()])
    return bytes(device.queue.read_buffer(result))


def test_pack_puts_values_where_the_dtype_says() -> None:
    values = (Small(a=7, b=(1.5, -2.0)), Small(a=9, b=(0.0, 3.0)))
    array = np.frombuffer(pack(*values), dtype(Small))
    assert array["a"].tolist() == [7, 9]
    assert array["b"].tolist() == [[1.5, -2.0], [0.0, 3.0]]
    assert len(pack(*values)) == 2 * 16


def test_an_array_at_the_end_follows_its_struct(tmp_path: Path) -> None:
    points = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0], [7.0, 8.0]])
    shader = tmp_path / "copy.wgsl"
    shader.write_text(
        "//#struct LightSamples\n"
        "@group(0) @binding(0) var<storage, read_write> results: LightSamples;\n"
        "@group(0) @binding(1) var<storage, read> samples: LightSamples;\n"
        "@compute @workgroup_size(1) fn cs_copy(@builtin(workgroup_id) id: vec3u) {\n"
        "    results.count = samples.count;\n    results.total_weight = samples.total_weight;\n"
        "    results.points[id.x] = samples.points[arrayLength(&samples.points) - 1u - id.x];\n}\n",
        encoding="utf-8",
    )
    data = run(shader, pack(samples_record(points, np.array([0.5, 2.0]))), len(points))  # two places of two samples
    assert np.frombuffer(data, dtype(LightSamples), 1)[0].tolist()[:2] == (2, 2.5)
    rows = np.frombuffer(data, np.float32, offset=dtype(LightSamples).itemsize).reshape(-1, 4)
    assert rows.tolist() == [[7.0, 8.0, 2.0, 0.0], [5.0, 6.0, 0.5, 0.0], [3.0, 4.0, 2.0, 0.0], [1.0, 2.0, 0.5, 0.0]]


def test_a_struct_within_a_struct(tmp_path: Path) -> None:
    """It begins at a multiple of its alignment, and takes its whole size."""
    made = dtype(Outer)
    assert made.fields is not None
    assert [made.fields[name][1] for name in "abcd"] == [0, 8, 24, 32]
    assert made.itemsize == 32 + dtype(Awkward).itemsize
    awkward = Awkward(a=1.5, b=(2.0, 3.0, 4.0), c=5, d=(6.0, 7.0), e=-8, f=(9.0, 1.0, 2.0, 3.0), g=(4, 5), h=(6, 7, 8))
    data = pack(Outer(a=1, b=Small(a=2, b=(0.5, -0.5)), c=3.0, d=awkward))
    shader = tmp_path / "copy.wgsl"
    shader.write_text(
        "//#struct Outer\n"
        "@group(0) @binding(0) var<storage, read_write> result: Outer;\n"
        "@group(0) @binding(1) var<storage, read> value: Outer;\n"
        "@compute @workgroup_size(1) fn cs_copy() {\n"
        "    result.b = value.b;\n    result.d.e = value.d.e;\n    result.d.h = value.d.h;\n}\n",
        encoding="utf-8",
    )
    copied = np.frombuffer(run(shader, data, 1), made)[0]
    assert copied["a"] == 0
    assert (copied["b"]["a"], copied["b"]["b"].tolist()) == (2, [0.5, -0.5])
    assert (copied["d"]["e"], copied["d"]["h"].tolist()) == (-8, [6.0, 7.0, 8.0])
