"""All shadow maps in one atlas by instanced draws, against one pass per layer of an array texture, interleaved.

    python benchmarks/atlas_vs_layers.py                 57 k triangles, 289 maps of 512²

All draw the same scene with the same projection into 32-bit depth. The atlas leaves out triangles of solids that look
away from the light; "layers" draws all of them, "layers, culled" leaves out the same ones. The layers need two
textures, since WebGPU's default limit is 256 layers. Medians: milliseconds from submit to finish, and milliseconds of
the CPU to encode.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import wgpu
from softshadows.visibility.maps.shadow_atlas import ShadowAtlas

import softshadows as ss
from softshadows.gpu.compose import shader_module
from softshadows.gpu.layout import dtype
from softshadows.passes.gbuffer.gbuffer import SCENE_STRUCTS
from softshadows.visibility.maps.structs import SHADOW_STRUCTS, DrawView

LAYERS = 256  # WebGPU's default limit


def read_buffer(device: wgpu.GPUDevice, buffer: wgpu.GPUBuffer) -> bytes:
    return bytes(device.queue.read_buffer(buffer))


class LayeredMaps:
    """The atlas's maps again, one pass per map, of opaque triangles alone."""

    def __init__(self, atlas: ShadowAtlas) -> None:
        self._atlas, self._device = atlas, atlas._gpu.device
        device, plan, usage = self._device, atlas.plan, wgpu.BufferUsage
        # The atlas's views, each stretched from its place in the atlas over a layer of its own.
        views = np.frombuffer(read_buffer(device, atlas.draw_views), dtype(DrawView)).copy()
        views = views[views["edges"][:, 2] > 0.0]
        unit = plan.atlas_size / plan.tile
        for row, axis in (("row_x", 0), ("row_y", 1)):
            views[row] = unit * (views[row] - views["edges"][:, axis, None] * views["row_w"])
        self.count = len(views)
        self._instances = device.create_buffer_with_data(data=views, usage=usage.VERTEX)
        module = shader_module(device, Path(__file__).with_suffix(".wgsl"), (*SHADOW_STRUCTS, *SCENE_STRUCTS))
        position = {"format": "float32x3", "offset": 0, "shader_location": 0}
        rows = [{"format": "float32x4", "offset": 16 * row, "shader_location": 1 + row} for row in range(5)]
        self._plain, self._culled = (
            device.create_render_pipeline(
                layout=device.create_pipeline_layout(bind_group_layouts=[atlas._draw_layout, atlas._scene.layout]),
                vertex={
                    "module": module,
                    "entry_point": "vs_layer",
                    "buffers": [
                        {"array_stride": 80, "step_mode": "instance", "attributes": rows},
                        {"array_stride": 12, "step_mode": "vertex", "attributes": [position]},
                    ],
                },
                primitive={"topology": "triangle-list", "front_face": "cw", "cull_mode": cull},
                depth_stencil={"format": "depth32float", "depth_write_enabled": True, "depth_compare": "greater"},
            )
            for cull in ("none", "back")
        )
        self._views = []
        for first in range(0, self.count, LAYERS):
            layers = min(LAYERS, self.count - first)
            texture = device.create_texture(
                size=(plan.tile, plan.tile, layers), format="depth32float", usage=wgpu.TextureUsage.RENDER_ATTACHMENT
            )
            self._views += [
                texture.create_view(dimension="2d", base_array_layer=layer, array_layer_count=1)
                for layer in range(layers)
            ]

    def encode(self, encoder: wgpu.GPUCommandEncoder, *, culled: bool) -> None:
        scene = self._atlas._scene
        solid = 3 * scene.solid_count if culled else 0
        for index, view in enumerate(self._views):
            attachment = {"view": view, "depth_load_op": "clear", "depth_store_op": "store", "depth_clear_value": 0.0}
            draw = encoder.begin_render_pass(color_attachments=[], depth_stencil_attachment=attachment)
            draw.set_bind_group(0, self._atlas._draw_bindings)
            draw.set_bind_group(1, scene.bindings)
            draw.set_vertex_buffer(0, self._instances, 80 * index)
            draw.set_vertex_buffer(1, scene.positions)
            draw.set_index_buffer(scene.indices, "uint32")
            if solid:
                draw.set_pipeline(self._culled)
                draw.draw_indexed(solid)
            draw.set_pipeline(self._plain)
            draw.draw_indexed(3 * scene.opaque_count - solid, 1, solid)
            draw.end()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=57_000)
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()

    scene = ss.scenes.field(count=arguments.triangles)
    assert scene.camera is not None
    with ss.Renderer(scene, technique=ss.techniques.Uniform(resolution=512), size=(320, 240)) as renderer:
        renderer.render(scene.camera)
        (atlas,) = renderer.passes.technique._atlases.values()
        layered = LayeredMaps(atlas)
        timer = renderer.passes.timer
        device = renderer._gpu.device

        def atlas_pass(encoder: wgpu.GPUCommandEncoder) -> None:
            for chunk in range(atlas.plan.chunks):
                starts_batch = atlas.plan.starts_batch(chunk)
                atlas.encode_draw(encoder, timer, chunk, clears_atlas=starts_batch, clears_views=False)

        def timed(encode: Callable[[wgpu.GPUCommandEncoder], None]) -> tuple[float, float]:
            started = time.perf_counter()
            encoder = device.create_command_encoder()
            encode(encoder)
            commands = encoder.finish()
            encoded = time.perf_counter()
            device.queue.submit([commands])
            device.queue.read_buffer(atlas.light, 0, 16)  # waits
            return 1e3 * (time.perf_counter() - encoded), 1e3 * (encoded - started)

        encoders: dict[str, Callable[[wgpu.GPUCommandEncoder], None]] = {
            "atlas": atlas_pass,
            "layers": partial(layered.encode, culled=False),
            "layers, culled": partial(layered.encode, culled=True),
        }
        rows: dict[str, list[tuple[float, float]]] = {name: [] for name in encoders}
        for _ in range(arguments.runs + 1):
            timer.begin_frame()
            for name, encode in encoders.items():
                rows[name].append(timed(encode))
    print(f"{scene.triangle_count} triangles, {atlas.plan.samples} samples, {layered.count} maps of {atlas.plan.tile}²")
    for name, times in rows.items():
        gpu_ms, cpu_ms = (statistics.median(column) for column in zip(*times[1:], strict=True))
        print(f"{name:15} {gpu_ms:8.0f} ms to draw   {cpu_ms:6.2f} ms to encode")
    for name in list(rows)[1:]:
        ratios = sorted(other / one for (one, _), (other, _) in zip(rows["atlas"][1:], rows[name][1:], strict=True))
        print(f"({name}) / atlas: median {statistics.median(ratios):.2f} (from {ratios[0]:.2f} to {ratios[-1]:.2f})")


if __name__ == "__main__":
    main()
