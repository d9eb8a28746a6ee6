"""All shadow maps of one light in one atlas, drawn by one instanced indirect draw.

    receivers.wgsl   boxes around what the camera sees and something can shadow, 8×8 pixels each, in light space
    windows.wgsl     per light sample: windows around those boxes, cut into cube faces
    placing.wgsl     the windows' places in the sample's tile, and the list of views to draw
    fit.wgsl         the windows of every sample, around all boxes
    draw.wgsl        the occluders, one instance per window

Everything is decided on the GPU; the CPU knows only sizes. Samples are grouped twice: a *batch* is what fits the atlas
at one time, a *chunk* what one submit may draw and look up without running into a driver's watchdog. Lights take turns
in the same buffers: per light a technique calls `encode_receivers`, a fit, and then, per chunk, `encode_draw` and its
own look-ups.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import wgpu

from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import DrawProgram, Program, Resource, Slice
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import PassTimer
from softshadows.lights.record import Chunk, LightSamples, light_record, samples_record
from softshadows.lights.record import Light as LightRecord
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.visibility.maps.extents import depth_range, farthest, reaches_into
from softshadows.visibility.maps.plan import AtlasPlan
from softshadows.visibility.maps.structs import (
    FACES,
    DrawView,
    ReceiverBox,
    ShadowMaps,
    ShadowView,
)

_USAGE = wgpu.BufferUsage
DRAWS = constant("visibility/maps/placing.wgsl", "DRAWS")
"""Per chunk: views to clear; triangles of solids that face the light, all other opaque ones, masked ones."""
DRAW_BYTES = 20  # of an indirect draw's arguments
DRAWN_BYTES = 4 * constant("visibility/maps/placing.wgsl", "DRAWN_WORDS")
"""Before the arguments: which samples' maps are in the atlas."""
FARTHEST_CORNER = 4.4
"""Distance of the farthest point of a window's near plane, in near distances: the front window's tangents reach 3."""
_DISCARDING = {"visibility/maps/kept_by_clipping.wgsl": "visibility/maps/kept_by_discard.wgsl"}
BOX_EDGE = constant("visibility/maps/receivers.wgsl", "EDGE")
"""Pixels along the side of a box of receivers."""
UNIFORM_ALIGNMENT = 256  # WebGPU: offset of a dynamic uniform


@dataclass(frozen=True, eq=False)
class SampledLight:
    """A light, its layer of visibility, its samples: points (places × n, 2), metres of light space; weights (n,)."""

    light: Light
    layer: int
    points: np.ndarray
    weights: np.ndarray


class ShadowAtlas:
    """The shadow maps of lights with `plan.samples` samples each, one light at a time.

    With `keeps_maps`, and where all of them fit the atlas, a map is drawn again only when the light or the scene has
    changed, or the camera sees receivers that it does not hold.

    `sample_resources`, `resources` and `fit_resources` are for programs that include light_samples.wgsl,
    shadow_map.wgsl and placing.wgsl, of which each declares them all; `chunk(number)` is what the first two call so.
    """

    def __init__(
        self,
        gpu: Gpu,
        scene: SceneBuffers,
        gbuffer: GBuffer,
        plan: AtlasPlan,
        *,
        margin_texels: int = 1,
        search_margin: float = 0.0,
        keeps_maps: bool = False,
        texels_per_pixel: float = 2.0,
    ) -> None:
        self.plan, self._gpu, self._scene, self._gbuffer = plan, gpu, scene, gbuffer
        self._margin_texels = margin_texels
        self._search_margin, self._texels_per_pixel = search_margin, texels_per_pixel
        self.keeps_maps = keeps_maps and plan.holds_all
        self._kept_for: tuple[Light, bytes, Geometry] | None = None  # light, its samples, scene
        self._groups = (-(-gbuffer.size[0] // BOX_EDGE), -(-gbuffer.size[1] // BOX_EDGE))
        self.bytes = plan.bytes
        self._staging: wgpu.GPUBuffer | None = None

        def buffer(size: int, usage: int = 0) -> wgpu.GPUBuffer:
            self.bytes += size
            return gpu.buffer(size, _USAGE.STORAGE | usage, "a shadow buffer")

        self.light = buffer(dtype(LightRecord).itemsize)
        self.settings = buffer(dtype(ShadowMaps).itemsize, _USAGE.UNIFORM)
        self.samples = buffer(dtype(LightSamples).itemsize + 16 * plan.places * plan.samples)
        assert plan.samples <= 32 * DRAWN_BYTES // 4
        self.draws = buffer(DRAWN_BYTES + DRAW_BYTES * DRAWS * plan.chunks, _USAGE.INDIRECT)
        self.views = buffer(dtype(ShadowView).itemsize * FACES * plan.samples)
        self.boxes = buffer(dtype(ReceiverBox).itemsize * self._groups[0] * self._groups[1])
        draw_views = FACES * plan.samples_per_chunk * plan.chunks
        self.draw_views = buffer(draw_views * dtype(DrawView).itemsize, _USAGE.VERTEX)
        self._chunks = gpu.buffer(UNIFORM_ALIGNMENT * plan.chunks, _USAGE.UNIFORM, "the chunks")
        self.bytes += self._chunks.size
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
        self.depth = gpu.texture((plan.atlas_size, plan.atlas_size), "depth32float", usage, "the shadow atlas")
        self.depth_view = self.depth.create_view()
        self._write_chunks()

        found: dict[str, Resource] = {
            **gbuffer.resources,
            "light": self.light,
            "maps": self.settings,
            "receiver_boxes": self.boxes,
            "occluder_boxes": scene.occluder_boxes,
        }
        self._bound_receivers = Program(gpu, "visibility/maps/receivers.wgsl", "cs_bound_receivers", found)
        self._fit = Program(gpu, "visibility/maps/fit.wgsl", "cs_fit_views", self.fit_resources)
        self._programs = self.draw_programs("greater")
        self._draws: dict[tuple[int, bool], wgpu.GPURenderBundle] = {}  # by chunk, with or without clearing its views
        attachment = {"view": self.depth_view, "depth_store_op": "store", "depth_clear_value": 0.0}
        self._loaded, self._cleared = ({**attachment, "depth_load_op": op} for op in ("load", "clear"))

    @property
    def sample_resources(self) -> dict[str, Resource]:
        """The light whose turn it is, and its samples."""
        return {"light": self.light, "light_samples": self.samples}

    @property
    def resources(self) -> dict[str, Resource]:
        """Its samples and their maps."""
        views: dict[str, Resource] = {"shadow_views": self.views, "shadow_atlas": self.depth_view}
        return {**self.sample_resources, "maps": self.settings, **views}

    @property
    def fit_resources(self) -> dict[str, Resource]:
        """What the maps' windows are found from, and where they are noted."""
        return {
            **self.sample_resources,
            "maps": self.settings,
            "receiver_boxes": self.boxes,
            "shadow_views": self.views,
            "draw_views": self.draw_views,
            "draws": self.draws,
        }

    def chunk(self, number: int) -> Slice:
        """The samples of one draw."""
        return Slice(self._chunks, UNIFORM_ALIGNMENT * number, dtype(Chunk).itemsize)

    def draw_programs(self, keeps: str) -> list[DrawProgram]:
        """The programs of a chunk's draws, of which a texel keeps the "greater" or the "less" closeness."""
        clips = "clip-distances" in self._gpu.features
        position = {"format": "float32x3", "offset": 0, "shader_location": 0}
        positions = {"array_stride": 12, "step_mode": "vertex", "attributes": [position]}
        rows = [
            {"format": "float32x4", "offset": 16 * row, "shader_location": 1 + row}
            for row in range(len(dtype(DrawView).names or ()))
        ]
        views = {"array_stride": dtype(DrawView).itemsize, "step_mode": "instance", "attributes": rows}

        def program(kind: str, buffers: list, fragment: str | None, cull: str, compare: str = keeps) -> DrawProgram:
            depth = {"format": "depth32float", "depth_write_enabled": True, "depth_compare": compare}
            return DrawProgram(
                self._gpu,
                "visibility/maps/draw.wgsl",
                f"vs_{kind}",
                fragment,
                {**self._scene.resources, "light": self.light, "maps": self.settings},
                state={
                    "primitive": {"topology": "triangle-list", "front_face": "cw", "cull_mode": cull},
                    "depth_stencil": depth,
                },
                vertex_buffers=buffers,
                stand_ins={} if clips else _DISCARDING,
            )

        opaque_fragment = None if clips else "fs_opaque"
        return [
            program("clear", [views], None, "none", "always"),
            program("opaque", [views, positions], opaque_fragment, "back"),
            program("opaque", [views, positions], opaque_fragment, "none"),
            program("masked", [views], "fs_masked", "none"),
        ]

    def _write_chunks(self) -> None:
        """The chunks' uniforms: the same for every frame."""
        plan = self.plan
        rows = np.zeros((plan.chunks, UNIFORM_ALIGNMENT), np.uint8)
        for index in range(plan.chunks):
            first = min(index * plan.samples_per_chunk, plan.samples)
            count = min(plan.samples_per_chunk, plan.samples - first)
            data = pack(Chunk(first_sample=first, sample_count=count))
            rows[index, : len(data)] = np.frombuffer(data, np.uint8)
        self._gpu.write(self._chunks, 0, rows, what="constant")

    def set_lights(self, lights: Sequence[SampledLight]) -> None:
        """Write this frame's lights; `encode_fit` takes them by their index."""
        self._lights = [(sampled.light, sampled.points.tobytes()) for sampled in lights]
        self._stride = sum(size for _, _, size in self._per_light)
        if self._staging is None or self._staging.size < self._stride * len(lights):
            self._staging = self._gpu.buffer(self._stride * len(lights), 0, "the lights that take turns")
        data = b"".join(self._light_bytes(light) for light in lights)
        self._gpu.write(self._staging, 0, data, what="light")

    @property
    def _per_light(self) -> list[tuple[wgpu.GPUBuffer, int, int]]:
        """Where one light at a time lies: buffers, offsets, bytes."""
        whole = [(buffer, 0, buffer.size) for buffer in (self.light, self.settings, self.samples)]
        return [*whole, (self.draws, DRAWN_BYTES, self.draws.size - DRAWN_BYTES)]

    def _light_bytes(self, sampled: SampledLight) -> bytes:
        """The contents of the per-light buffers, one after the other."""
        plan, scene, light = self.plan, self._scene, sampled.light
        directional = light.is_directional
        near, far = max(1e-5 * scene.diagonal, 1e-7), farthest(scene.geometry.bounds, light.center)
        if directional:
            near, far = depth_range(scene.geometry.bounds, -light.axes[2])
        settings = ShadowMaps(
            near=near,
            far=far,
            depth_scale=1.0 if directional else near,
            window_scale=max(scene.diagonal, 1e-6) if directional else 1.0,
            bias_scale=1.0,
            texels_per_pixel=self._texels_per_pixel,
            margin_texels=float(self._margin_texels),
            search_margin=self._search_margin,
            is_auto=int(plan.is_auto),
            tile_size=plan.tile,
            tiles_per_row=plan.tiles_per_row,
            atlas_size=plan.atlas_size,
            occluder_count=scene.occluder_count,
            samples_per_batch=plan.samples_per_batch,
            samples_per_chunk=plan.samples_per_chunk,
        )
        samples = samples_record(sampled.points, sampled.weights)
        # A chunk's draws: count, instances (filled by the fit), first, base vertex, first instance.
        solid = 0 if reaches_into(scene.geometry.solid_boxes, light, FARTHEST_CORNER * near) else scene.solid_count
        ends = 3 * np.array([0, solid, scene.opaque_count, scene.triangle_count])
        arguments = np.zeros((DRAWS, DRAW_BYTES // 4), np.uint32)
        arguments[0, 0] = 6
        arguments[1:, 0], arguments[1:, 2] = np.diff(ends), ends[:-1]
        records = pack(light_record(light, sampled.layer)) + pack(settings) + pack(samples)
        return records + np.tile(arguments, (plan.chunks, 1)).tobytes()

    def encode_receivers(self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer, index: int) -> None:
        """Let light `index` take its turn: boxes around what the G-buffer sees and something can shadow."""
        assert self._staging is not None, "set_lights() comes before encode_receivers()"
        drawn_for = (*self._lights[index], self._scene.geometry)
        if not self.keeps_maps or drawn_for != self._kept_for:
            encoder.clear_buffer(self.draws, 0, DRAWN_BYTES)
            self._kept_for = drawn_for
        offset = index * self._stride
        for buffer, place, size in self._per_light:
            encoder.copy_buffer_to_buffer(self._staging, offset, buffer, place, size)
            offset += size
        fit = encoder.begin_compute_pass(timestamp_writes=timer.writes("fit"))
        self._bound_receivers.dispatch(fit, self._groups)
        fit.end()

    def encode_fit(self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer) -> None:
        """Fit all the light's views to its receivers."""
        fit = encoder.begin_compute_pass(timestamp_writes=timer.writes("fit"))
        self._fit.dispatch(fit, (self.plan.samples,))
        fit.end()

    def encode_draw(
        self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer, chunk: int, *, clears_atlas: bool, clears_views: bool
    ) -> None:
        """Draw the chunk's occluders, into a cleared atlas, or into views that are cleared one by one."""
        attachment = self._cleared if clears_atlas else self._loaded
        if (chunk, clears_views) not in self._draws:
            self._draws[chunk, clears_views] = self.record_draws(chunk, self._programs, clears_views=clears_views)
        draw = encoder.begin_render_pass(
            color_attachments=[], depth_stencil_attachment=attachment, timestamp_writes=timer.writes("shadow_maps")
        )
        draw.execute_bundles([self._draws[chunk, clears_views]])
        draw.end()

    def record_draws(self, chunk: int, programs: Sequence[DrawProgram], *, clears_views: bool) -> wgpu.GPURenderBundle:
        """The chunk's draws, to be replayed every frame: the buffers they name are as old as the atlas or its scene."""
        scene, (clear, solid, opaque, masked) = self._scene, programs
        draw = self._gpu.device.create_render_bundle_encoder(color_formats=[], depth_stencil_format="depth32float")
        first_view = chunk * self.plan.samples_per_chunk * FACES
        draw.set_vertex_buffer(0, self.draw_views, first_view * dtype(DrawView).itemsize)
        arguments = DRAWN_BYTES + DRAW_BYTES * DRAWS * chunk
        if clears_views:
            clear.begin(draw)
            draw.draw_indirect(self.draws, arguments)
        if scene.opaque_count:
            draw.set_vertex_buffer(1, scene.positions)
            draw.set_index_buffer(scene.indices, "uint32")
            solid.begin(draw)
            draw.draw_indexed_indirect(self.draws, arguments + DRAW_BYTES)
            opaque.begin(draw)
            draw.draw_indexed_indirect(self.draws, arguments + 2 * DRAW_BYTES)
        if scene.triangle_count > scene.opaque_count:
            masked.begin(draw)
            draw.draw_indirect(self.draws, arguments + 3 * DRAW_BYTES)
        return draw.finish()
