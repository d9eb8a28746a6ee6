"""A compute shader with what it is bound to: for passes whose kernels each use their own few buffers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import wgpu

from softshadows.gpu.compose import compose, label, shader_module
from softshadows.gpu.device import Gpu

Resource = wgpu.GPUBuffer | wgpu.GPUTextureView


class Kernel:
    """An entry point and its bind groups: `groups` maps group and binding to what the shader declares there.

    The pipeline's layout comes from the shader, so only what the entry uses may be given.
    """

    def __init__(
        self,
        gpu: Gpu,
        file: Path,
        entry: str,
        groups: Mapping[int, Mapping[int, Resource]],
        constants: Mapping[str, float] | None = None,
        stand_ins: Mapping[str, str] | None = None,
    ) -> None:
        self._device = gpu.device
        module = shader_module(gpu.device, compose(file, stand_ins), label(file))
        compute = {"module": module, "entry_point": entry, "constants": dict(constants or {})}
        self._pipeline = gpu.device.create_compute_pipeline(layout="auto", compute=compute)
        self._groups = {group: self.bind(group, resources) for group, resources in groups.items()}

    def bind(self, group: int, resources: Mapping[int, Resource]) -> wgpu.GPUBindGroup:
        """A bind group of this kernel, for `begin` to take in place of a fixed one."""
        entries = [
            {"binding": binding, "resource": {"buffer": item} if isinstance(item, wgpu.GPUBuffer) else item}
            for binding, item in resources.items()
        ]
        layout = self._pipeline.get_bind_group_layout(group)
        return self._device.create_bind_group(layout=layout, entries=entries)

    def begin(
        self, compute: wgpu.GPUComputePassEncoder, changing: Mapping[int, wgpu.GPUBindGroup] | None = None
    ) -> None:
        """Make this the kernel that the pass's next dispatch runs."""
        compute.set_pipeline(self._pipeline)
        for group, bindings in {**self._groups, **(changing or {})}.items():
            compute.set_bind_group(group, bindings)
