"""share.wgsl against float64 numpy: the visible share equals the paper's formula of angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import wgpu

import softshadows
from occluding_edges_model import angles_share
from softshadows.gpu.compose import compose, shader_module
from softshadows.gpu.device import acquire

SHARE = Path(softshadows.__file__).parent / "techniques" / "occluding_edges" / "share.wgsl"
COUNT = 1000
KERNEL = """
@group(0) @binding(0) var<storage, read_write> result: array<f32>;
@group(0) @binding(1) var<storage, read> cases: array<vec4f>;  // ahead, closer, length of the segment

@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    result[id.x] = visible_share(cases[id.x].x, cases[id.x].y, cases[id.x].z);
}
"""


def run(cases: np.ndarray, tmp_path: Path) -> np.ndarray:
    shader = tmp_path / "share_test.wgsl"
    shader.write_text(SHARE.read_text(encoding="utf-8") + KERNEL, encoding="utf-8")
    device, usage = acquire().device, wgpu.BufferUsage
    data = np.zeros((len(cases), 4), np.float32)
    data[:, :3] = cases
    result = device.create_buffer(size=4 * len(cases), usage=usage.STORAGE | usage.COPY_SRC)
    given = device.create_buffer_with_data(data=data.tobytes(), usage=usage.STORAGE)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": shader_module(device, compose(shader), shader.name), "entry_point": "cs_test"}
    )
    entries = [{"binding": i, "resource": {"buffer": buffer}} for i, buffer in enumerate((result, given))]
    bindings = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(len(cases))
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.asarray(device.queue.read_buffer(result)).view("<f4").astype(np.float64)


def test_the_share_is_the_papers_formula_to_1e_5(tmp_path: Path) -> None:
    """Edges between 10 % and 80 % of the way to the light, so that float32 inputs leave five digits."""
    random = np.random.default_rng(7)
    left, length = np.zeros((COUNT, 2)), random.uniform(0.5, 4.0, COUNT)
    right = np.stack([length, np.zeros(COUNT)], axis=-1)
    fragment = np.stack([random.uniform(-3.0, 3.0, COUNT), random.uniform(2.0, 8.0, COUNT)], axis=-1)
    point = random.uniform(0.0, 1.0, COUNT)[:, None] * right
    edge = fragment + random.uniform(0.1, 0.8, COUNT)[:, None] * (point - fragment)
    ahead = edge[:, 0] / edge[:, 1] - fragment[:, 0] / fragment[:, 1]
    closer = 1.0 / edge[:, 1] - 1.0 / fragment[:, 1]
    found = run(np.stack([ahead, closer, length], axis=-1), tmp_path)
    np.testing.assert_allclose(found, angles_share(left, right, fragment, edge), atol=1e-5)


def test_what_is_behind_or_beyond_hides_nothing_and_what_is_passed_hides_all(tmp_path: Path) -> None:
    cases = np.array([(0.1, -0.5, 1.0), (0.1, 0.0, 1.0), (0.6, 0.5, 1.0), (0.0, 0.5, 1.0), (-0.1, 0.5, 1.0)])
    assert run(cases, tmp_path).tolist() == [1.0, 1.0, 1.0, 0.0, 0.0]
