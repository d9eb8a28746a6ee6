"""What the camera sees and something can shadow: receivers.wgsl puts boxes around it, which windows are fitted to."""

from __future__ import annotations

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, Struct, Vec3f, dtype
from softshadows.gpu.program import Program, Resource
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.passes.gbuffer.gbuffer import GBuffer

BOX_EDGE = constant("visibility/receivers.wgsl", "EDGE")
"""Pixels along the side of a box of receivers."""


class ReceiverBox(Struct):
    """Receivers of 8×8 pixels: their extent in light space, their number, the mean width of their pixels in metres."""

    low: Vec3f
    count: F32
    high: Vec3f
    footprint: F32


class OccluderBox(Struct):
    """World extent of a cluster of triangles."""

    low_ws: Vec3f
    high_ws: Vec3f


class ReceiverBoxes:
    """Boxes around the receivers of the light in the buffer `light` (record.py)."""

    def __init__(self, gpu: Gpu, scene: SceneBuffers, gbuffer: GBuffer, light: wgpu.GPUBuffer) -> None:
        self._groups = (-(-gbuffer.size[0] // BOX_EDGE), -(-gbuffer.size[1] // BOX_EDGE))
        size = dtype(ReceiverBox).itemsize * self._groups[0] * self._groups[1]
        self._boxes = gpu.storage_buffer(size, "the receivers' boxes")
        self.bytes = self._boxes.size
        resources: dict[str, Resource] = {
            **gbuffer.resources,
            **self.resources,
            "light": light,
            "occluder_boxes": scene.occluder_boxes,
        }
        self._bound_receivers = Program(gpu, "visibility/receivers.wgsl", "cs_bound_receivers", resources)

    @property
    def resources(self) -> dict[str, Resource]:
        """The boxes, for programs that declare them."""
        return {"receiver_boxes": self._boxes}

    def encode(self, commands: Commands) -> None:
        """Find them for what the G-buffer holds."""
        with commands.compute("fit") as compute:
            self._bound_receivers.dispatch(compute, self._groups)
