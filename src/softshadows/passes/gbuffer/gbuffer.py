"""What the camera sees: position, geometric and shading normal and material of the surface at every pixel.

Two steps: draw the nearest triangle's number, then intersect each pixel's ray with that triangle in a compute pass.
"""

from __future__ import annotations

import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, Struct, Vec2u, Vec3f, dtype, pack
from softshadows.gpu.program import DrawProgram, Program, Resource, view_of
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.scene.camera import Camera

_USAGE = wgpu.TextureUsage
BYTES_PER_PIXEL = 4 + 4 + 16 + 16 + 16
_TRIANGLES = {"topology": "triangle-list", "cull_mode": "none"}
_NEAREST = {"format": "depth32float", "depth_write_enabled": True, "depth_compare": "greater"}


class FrameUniforms(Struct):
    """The camera and the image. `pixel_extent` is a pixel's height one metre in front of the camera."""

    camera_position_ws: Vec3f
    camera_right_ws: Vec3f
    tan_half_width: F32
    camera_up_ws: Vec3f
    tan_half_height: F32
    camera_back_ws: Vec3f
    near: F32
    size: Vec2u
    pixel_extent: F32
    scene_diagonal: F32


class GBuffer:
    """The pass and its textures, all of the image's size.

    position: rgba32float, xyz world space, w linear view depth, 0 where there is no surface; normal: rgba32float,
    geometric, unit, facing the viewer; material: rgba32uint (shading normal, base colour, roughness and metallic,
    emission; lighting.wgsl).
    """

    def __init__(self, gpu: Gpu, scene: SceneBuffers, size: tuple[int, int]) -> None:
        self._gpu, self.scene, self.size = gpu, scene, size
        self.bytes = BYTES_PER_PIXEL * size[0] * size[1]
        gpu.check_buffer(4 * size[0] * size[1], "the visibility of one light")  # before textures exhaust the memory

        def texture(format: str, usage: int) -> wgpu.GPUTexture:
            return gpu.texture(size, format, usage, "the image")

        read = _USAGE.TEXTURE_BINDING | _USAGE.STORAGE_BINDING | _USAGE.COPY_SRC
        self._numbers = texture("r32uint", _USAGE.RENDER_ATTACHMENT | _USAGE.TEXTURE_BINDING)
        self._depth = texture("depth32float", _USAGE.RENDER_ATTACHMENT)
        self._numbers_view, self._depth_view = view_of(self._numbers), view_of(self._depth)
        self.position = texture("rgba32float", read)
        self.normal = texture("rgba32float", read)
        self.material = texture("rgba32uint", read)
        self.position_view, self.normal_view = view_of(self.position), view_of(self.normal)
        self.material_view = view_of(self.material)
        self.uniforms = gpu.buffer(dtype(FrameUniforms).itemsize, wgpu.BufferUsage.UNIFORM, "the camera")

        seen: dict[str, Resource] = {**scene.resources, "frame": self.uniforms}
        self._opaque, self._masked = (
            DrawProgram(
                gpu,
                "passes/gbuffer/gbuffer.wgsl",
                f"vs_{kind}",
                f"fs_{kind}",
                seen,
                state={"primitive": _TRIANGLES, "depth_stencil": _NEAREST},
                targets=[{"format": "r32uint"}],
            )
            for kind in ("opaque", "masked")
        )
        self._resolve = Program(
            gpu,
            "passes/gbuffer/resolve.wgsl",
            "cs_resolve",
            {
                **seen,
                "triangle_numbers": self._numbers_view,
                "g_position": self.position_view,
                "g_normal": self.normal_view,
                "g_material": self.material_view,
            },
        )

    @property
    def resources(self) -> dict[str, Resource]:
        """What receiver.wgsl declares: the camera, and the surface at every pixel."""
        return {"frame": self.uniforms, "g_position": self.position_view, "g_normal": self.normal_view}

    def write(self, camera: Camera) -> None:
        """Write the frame's uniforms."""
        width, height = self.size
        right, up, back = camera.axes
        half = camera.pixel_extent(height) * height / 2.0
        uniforms = FrameUniforms(
            camera_position_ws=camera.position,
            camera_right_ws=tuple(right),
            tan_half_width=half * width / height,
            camera_up_ws=tuple(up),
            tan_half_height=half,
            camera_back_ws=tuple(back),
            near=max(1e-5 * self.scene.diagonal, 1e-6),
            size=self.size,
            pixel_extent=camera.pixel_extent(height),
            scene_diagonal=self.scene.diagonal,
        )
        self._gpu.write(self.uniforms, 0, pack(uniforms), what="camera")

    def encode(self, commands: Commands) -> None:
        scene = self.scene
        color = {"view": self._numbers_view, "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
        depth = {
            "view": self._depth_view,
            "depth_load_op": "clear",
            "depth_store_op": "discard",
            "depth_clear_value": 0.0,
        }
        with commands.draw("gbuffer", color_attachments=[color], depth_stencil_attachment=depth) as draw:
            if scene.opaque_count:
                self._opaque.begin(draw)
                draw.draw(3 * scene.opaque_count)
            if scene.triangle_count > scene.opaque_count:
                self._masked.begin(draw)
                draw.draw(3 * (scene.triangle_count - scene.opaque_count), 1, 3 * scene.opaque_count)
        with commands.compute("gbuffer") as compute:
            self._resolve.dispatch(compute, (-(-self.size[0] // 8), -(-self.size[1] // 8)))


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height in pixels. OptionError where they are none."""
    try:
        width, height = (int(extent) for extent in size)
    except (TypeError, ValueError):
        raise OptionError(f"size must be (width, height) in pixels, got {size!r}") from None
    if min(width, height) < 1:
        raise OptionError(f"size must be at least 1×1 pixels, got {size!r}")
    return width, height
