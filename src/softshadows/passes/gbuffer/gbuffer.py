"""What the camera sees: position, geometric and shading normal and material of the surface at every pixel.

Two steps: draw the nearest triangle's number, then intersect each pixel's ray with that triangle in a compute pass.
"""

from __future__ import annotations

from pathlib import Path

import wgpu

from softshadows.gpu.compose import shader_module
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, U32, Struct, Vec2u, Vec3f, dtype, pack
from softshadows.gpu.texture_pages import TextureRecord
from softshadows.gpu.timing import PassTimer
from softshadows.gpu.upload import MaterialRecord, SceneBuffers, VertexAttributes
from softshadows.scene.camera import Camera

_HERE = Path(__file__).parent
_USAGE = wgpu.TextureUsage
SCENE_STRUCTS = (VertexAttributes, MaterialRecord, TextureRecord)
BYTES_PER_PIXEL = 4 + 4 + 16 + 16 + 16


class FrameUniforms(Struct):
    """The camera and the image. `pixel_extent` is a pixel's height one metre in front of the camera."""

    camera_position_ws: Vec3f
    light_count: U32
    camera_right_ws: Vec3f
    tan_half_width: F32
    camera_up_ws: Vec3f
    tan_half_height: F32
    camera_back_ws: Vec3f
    near: F32
    size: Vec2u
    pixel_extent: F32


class GBuffer:
    """The pass and its textures, all of the image's size.

    position: rgba32float, xyz world space, w linear view depth, 0 where there is no surface; normal: rgba32float,
    geometric, unit, facing the viewer; material: rgba32uint (shading normal, base colour, roughness and metallic,
    emission; lighting.wgsl).
    """

    def __init__(self, gpu: Gpu, scene: SceneBuffers, size: tuple[int, int]) -> None:
        gpu.check_texture(*size, "the image")
        self._gpu, self._scene, self.size = gpu, scene, size
        device = gpu.device
        self.bytes = BYTES_PER_PIXEL * size[0] * size[1]

        def texture(format: str, usage: int) -> wgpu.GPUTexture:
            return device.create_texture(size=(*size, 1), format=format, usage=usage)

        read = _USAGE.TEXTURE_BINDING | _USAGE.STORAGE_BINDING | _USAGE.COPY_SRC
        self._numbers = texture("r32uint", _USAGE.RENDER_ATTACHMENT | _USAGE.TEXTURE_BINDING)
        self._depth = texture("depth32float", _USAGE.RENDER_ATTACHMENT)
        self._numbers_view, self._depth_view = self._numbers.create_view(), self._depth.create_view()
        self.position = texture("rgba32float", read)
        self.normal = texture("rgba32float", read)
        self.material = texture("rgba32uint", read)
        buffer = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self.uniforms = device.create_buffer(size=dtype(FrameUniforms).itemsize, usage=buffer)

        stages = wgpu.ShaderStage
        frame = {"binding": 0, "visibility": stages.VERTEX | stages.FRAGMENT, "buffer": {"type": "uniform"}}
        frame_layout = device.create_bind_group_layout(entries=[frame])
        self._frame = device.create_bind_group(
            layout=frame_layout, entries=[{"binding": 0, "resource": {"buffer": self.uniforms}}]
        )
        self.receiver_layout, self.receiver_bindings = self._bind_receivers()
        module = shader_module(device, _HERE / "gbuffer.wgsl", (FrameUniforms, *SCENE_STRUCTS))
        layout = device.create_pipeline_layout(bind_group_layouts=[frame_layout, scene.layout])
        self._opaque, self._masked = (
            device.create_render_pipeline(
                layout=layout,
                vertex={"module": module, "entry_point": "vs_triangle"},
                primitive={"topology": "triangle-list", "cull_mode": "none"},
                depth_stencil={"format": "depth32float", "depth_write_enabled": True, "depth_compare": "greater"},
                fragment={"module": module, "entry_point": entry, "targets": [{"format": "r32uint"}]},
            )
            for entry in ("fs_opaque", "fs_masked")
        )

        def storage(binding: int, format: str) -> dict:
            access = {"access": "write-only", "format": format}
            return {"binding": binding, "visibility": stages.COMPUTE, "storage_texture": access}

        resolve_layout = device.create_bind_group_layout(
            entries=[
                {"binding": 0, "visibility": stages.COMPUTE, "buffer": {"type": "uniform"}},
                {"binding": 1, "visibility": stages.COMPUTE, "texture": {"sample_type": "uint"}},
                storage(2, "rgba32float"),
                storage(3, "rgba32float"),
                storage(4, "rgba32uint"),
            ]
        )
        resources = [{"buffer": self.uniforms}] + [
            view.create_view() for view in (self._numbers, self.position, self.normal, self.material)
        ]
        self._resolve_bindings = device.create_bind_group(
            layout=resolve_layout,
            entries=[{"binding": i, "resource": resource} for i, resource in enumerate(resources)],
        )
        self._resolve = device.create_compute_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=[resolve_layout, scene.layout]),
            compute={
                "module": shader_module(device, _HERE / "resolve.wgsl", (FrameUniforms, *SCENE_STRUCTS)),
                "entry_point": "cs_resolve",
            },
        )

    def _bind_receivers(self) -> tuple[wgpu.GPUBindGroupLayout, wgpu.GPUBindGroup]:
        """Bind group 0 of passes that include receiver.wgsl."""
        compute, unfilterable = wgpu.ShaderStage.COMPUTE, {"sample_type": "unfilterable-float"}
        layout = self._gpu.device.create_bind_group_layout(
            entries=[
                {"binding": 0, "visibility": compute, "buffer": {"type": "uniform"}},
                {"binding": 1, "visibility": compute, "texture": unfilterable},
                {"binding": 2, "visibility": compute, "texture": unfilterable},
            ]
        )
        resources = [{"buffer": self.uniforms}, self.position.create_view(), self.normal.create_view()]
        entries = [{"binding": i, "resource": resource} for i, resource in enumerate(resources)]
        return layout, self._gpu.device.create_bind_group(layout=layout, entries=entries)

    def set_camera(self, camera: Camera, light_count: int) -> None:
        """Write the frame's uniforms."""
        width, height = self.size
        right, up, back = camera.axes
        half = camera.pixel_extent(height) * height / 2.0
        uniforms = FrameUniforms(
            camera_position_ws=camera.position,
            light_count=light_count,
            camera_right_ws=tuple(right),
            tan_half_width=half * width / height,
            camera_up_ws=tuple(up),
            tan_half_height=half,
            camera_back_ws=tuple(back),
            near=max(1e-5 * self._scene.diagonal, 1e-6),
            size=self.size,
            pixel_extent=camera.pixel_extent(height),
        )
        self._gpu.device.queue.write_buffer(self.uniforms, 0, pack(uniforms))

    def encode(self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer) -> None:
        scene = self._scene
        color = {
            "view": self._numbers.create_view(),
            "load_op": "clear",
            "store_op": "store",
            "clear_value": (0, 0, 0, 0),
        }
        depth = {
            "view": self._depth_view,
            "depth_load_op": "clear",
            "depth_store_op": "discard",
            "depth_clear_value": 0.0,
        }
        draw = encoder.begin_render_pass(
            color_attachments=[color], depth_stencil_attachment=depth, timestamp_writes=timer.writes("gbuffer")
        )
        draw.set_bind_group(0, self._frame)
        draw.set_bind_group(1, scene.bindings)
        if scene.opaque_count:
            draw.set_pipeline(self._opaque)
            draw.draw(3 * scene.opaque_count)
        if scene.triangle_count > scene.opaque_count:
            draw.set_pipeline(self._masked)
            draw.draw(3 * (scene.triangle_count - scene.opaque_count), 1, 3 * scene.opaque_count)
        draw.end()

        resolve = encoder.begin_compute_pass(timestamp_writes=timer.writes("gbuffer"))
        resolve.set_pipeline(self._resolve)
        resolve.set_bind_group(0, self._resolve_bindings)
        resolve.set_bind_group(1, scene.bindings)
        resolve.dispatch_workgroups(-(-self.size[0] // 8), -(-self.size[1] // 8))
        resolve.end()
