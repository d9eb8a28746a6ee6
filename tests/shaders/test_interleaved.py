"""interleaved.wgsl: every row of workgroups once, and each processor's share spread over the image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import wgpu

from softshadows.gpu.budget import INTERLEAVED, interleaved_groups
from softshadows.gpu.compose import PACKAGE, compose, shader_module
from softshadows.gpu.device import acquire

KERNEL = """
@group(0) @binding(0) var<storage, read_write> rows: array<u32>;

@compute @workgroup_size(1)
fn cs_test(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u) {
    rows[group.y] = interleaved_row(group.y, groups.y);
}
"""


def interleaved_rows(count: int, folder: Path) -> np.ndarray:
    shader = folder / "interleaved_test.wgsl"
    shader.write_text((PACKAGE / "gpu/interleaved.wgsl").read_text(encoding="utf-8") + KERNEL, encoding="utf-8")
    device, usage = acquire().device, wgpu.BufferUsage
    rows = device.create_buffer(size=4 * count, usage=usage.STORAGE | usage.COPY_SRC)
    module = shader_module(device, compose(shader), shader.name)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "cs_test"})
    entries = [{"binding": 0, "resource": {"buffer": rows}}]
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries))
    compute.dispatch_workgroups(1, count)
    compute.end()
    device.queue.submit([encoder.finish()])
    return np.asarray(device.queue.read_buffer(rows)).view("<u4")


@pytest.mark.parametrize("height", [1, 48, 384, 600, 1080])
def test_rows_are_permuted(height: int, tmp_path: Path) -> None:
    columns, count = interleaved_groups((100, height))
    assert columns == 13
    assert count % INTERLEAVED == 0
    assert 8 * count >= height > 8 * (count - INTERLEAVED)
    rows = interleaved_rows(count, tmp_path)
    assert sorted(rows) == [*range(count)]


@pytest.mark.parametrize("processors", [2, 4, 16])
def test_shares_are_spread(processors: int, tmp_path: Path) -> None:
    """A processor's rows begin near the top, end near the bottom, and leave no wider gap than its share asks for."""
    rows = interleaved_rows(64, tmp_path)
    for share in np.split(rows, processors):
        gaps = np.diff(np.concatenate([[-1], np.sort(share), [64]]))
        assert gaps.max() <= processors
