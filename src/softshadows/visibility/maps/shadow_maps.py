"""The shadow maps of a light's samples in one atlas, drawn by one instanced indirect draw.

    ../receivers.wgsl   boxes around what the camera sees and something can shadow, 8×8 pixels each, in light space
    windows.wgsl        per light sample: windows around those boxes, cut into cube faces
    placing.wgsl        the windows' places in the sample's tile, and the list of views to draw
    fit.wgsl            the windows of every sample, around all boxes
    draw.wgsl           the occluders, one instance per window

Everything is decided on the GPU; the CPU knows only sizes. Samples are grouped twice: a *batch* is what fits the atlas
at one time, a *chunk* what one submit may draw and look up without running into a driver's watchdog. Several lights
are selected one by one: per light `encode_selection`, then, per chunk, `encode_chunk` and the look-ups. Techniques
with a fit of their own call `encode_receivers`, the fit, and `encode_draw`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import DrawProgram, Program, Resource, view_of
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.selection import Selection
from softshadows.lights.sample_sets import SampledLight, SampleSet
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.visibility.maps.extents import depths, reaches_into
from softshadows.visibility.maps.plan import AtlasPlan
from softshadows.visibility.maps.structs import FACES, DrawView, MapSettings, ShadowView
from softshadows.visibility.provider import Provider
from softshadows.visibility.receivers import ReceiverBoxes

_USAGE = wgpu.BufferUsage
DRAWS = constant("visibility/maps/placing.wgsl", "DRAWS")
"""Per chunk: views to clear; triangles of solids that face the light, all other opaque ones, masked ones."""
DRAW_BYTES = 20  # of an indirect draw's arguments
HEAD_BYTES = 4 * (constant("visibility/maps/placing.wgsl", "DRAWN_WORDS") + 1)
"""Before the draws' arguments: which samples' maps are in the atlas, and whether a looser fit may serve."""
FARTHEST_CORNER = 4.4
"""Distance of the farthest point of a window's near plane, in near distances: the front window's tangents reach 3."""
_DISCARDING = {"visibility/maps/kept_by_clipping.wgsl": "visibility/maps/kept_by_discard.wgsl"}


@dataclass(frozen=True)
class MapOptions:
    """What a technique asks of its maps.

    `margin_texels` around a window, and `search_margin` half lights around the receivers, are what look-ups reach
    beyond them. `caches`: where all maps fit the atlas, and one light has it to itself, a map is redrawn only when the
    light or the scene has changed, or the camera sees receivers for which it would be another one.
    """

    margin_texels: int = 1
    search_margin: float = 0.0
    texels_per_pixel: float = 2.0
    caches: bool = False


class ShadowMaps(Provider):
    """The shadow maps of lights with `plan.samples` samples each, one light at a time.

    `samples.resources`, `resources` and `fit_resources` are what light_samples.wgsl, shadow_map.wgsl and placing.wgsl
    declare.
    """

    def __init__(
        self,
        gpu: Gpu,
        scene: SceneBuffers,
        gbuffer: GBuffer,
        plan: AtlasPlan,
        options: MapOptions = MapOptions(),
    ) -> None:
        self.plan, self._gpu, self._scene, self._options = plan, gpu, scene, options
        assert plan.samples <= 8 * HEAD_BYTES - 32
        self._lights: list[SampledLight] = []
        self._drawn_for: tuple[Light, bytes, Geometry] | None = None
        self.samples = SampleSet(gpu, plan.samples, per_chunk=plan.samples_per_chunk)
        self.receivers = ReceiverBoxes(gpu, scene, gbuffer, self.samples.light)

        def buffer(size: int, usage: int, what: str) -> wgpu.GPUBuffer:
            return gpu.buffer(size, _USAGE.STORAGE | usage, what)

        self.settings = buffer(dtype(MapSettings).itemsize, _USAGE.UNIFORM, "the settings of shadow maps")
        size = HEAD_BYTES + DRAW_BYTES * DRAWS * plan.chunks
        self.draws = buffer(size, _USAGE.INDIRECT, "the draws of shadow maps")
        self.views = buffer(dtype(ShadowView).itemsize * FACES * plan.samples, 0, "the views of shadow maps")
        size = FACES * plan.samples_per_chunk * plan.chunks * dtype(DrawView).itemsize
        self.draw_views = buffer(size, _USAGE.VERTEX, "the views to draw")
        self._selection = Selection(gpu, [(self.settings, 0), (self.draws, HEAD_BYTES - 4)])
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
        self.depth = gpu.texture((plan.atlas_size, plan.atlas_size), "depth32float", usage, "the shadow atlas")
        self.depth_view = view_of(self.depth)

        self._fit = Program(gpu, "visibility/maps/fit.wgsl", "cs_fit_views", self.fit_resources)
        self._programs = self.draw_programs("greater")
        self._draws: dict[tuple[int, bool], wgpu.GPURenderBundle] = {}  # by chunk, with or without clearing its views
        attachment = {"view": self.depth_view, "depth_store_op": "store", "depth_clear_value": 0.0}
        self._loaded, self._cleared = ({**attachment, "depth_load_op": op} for op in ("load", "clear"))

    @property
    def bytes(self) -> int:
        buffers = (self.settings, self.draws, self.views, self.draw_views)
        parts = (self.plan, self.samples, self.receivers, self._selection)
        return sum(buffer.size for buffer in buffers) + sum(part.bytes for part in parts)

    @property
    def can_cache(self) -> bool:
        return self._options.caches and self.plan.holds_all

    @property
    def _caches(self) -> bool:
        """Does the atlas hold all maps from frame to frame?"""
        return self.can_cache and len(self._lights) == 1

    @property
    def chunk_ms(self) -> float:
        return self.plan.samples_per_chunk * self._scene.triangle_count / self._gpu.budget.triangles_per_ms

    @property
    def resources(self) -> dict[str, Resource]:
        views: dict[str, Resource] = {"shadow_views": self.views, "shadow_atlas": self.depth_view}
        return {**self.samples.resources, "maps": self.settings, **views}

    @property
    def fit_resources(self) -> dict[str, Resource]:
        """What the maps' windows are found from, and where they are noted."""
        return {
            **self.samples.resources,
            **self.receivers.resources,
            "maps": self.settings,
            "shadow_views": self.views,
            "draw_views": self.draw_views,
            "draws": self.draws,
        }

    # -- Per frame -----------------------------------------------------------------------------------------------------

    def write(self, lights: Sequence[SampledLight], *, keeps_looser_fits: bool = False) -> None:
        self._lights = list(lights)
        self.samples.write(lights)
        contents = [
            pack(self._settings(each.light)) + self._arguments(each.light, keeps_looser_fits) for each in lights
        ]
        self._selection.write(contents, "light")
        drawn_for = (lights[0].light, lights[0].points.tobytes(), self._scene.geometry) if self._caches else None
        if drawn_for is None or drawn_for != self._drawn_for:
            self._gpu.write(self.draws, 0, bytes(HEAD_BYTES), what="light")
        self._drawn_for = drawn_for

    def _settings(self, light: Light) -> MapSettings:
        plan, scene, options = self.plan, self._scene, self._options
        near, far = depths(light, scene.geometry.bounds, self._near)
        return MapSettings(
            near=near,
            far=far,
            depth_scale=1.0 if light.is_directional else near,
            window_scale=max(scene.diagonal, 1e-6) if light.is_directional else 1.0,
            texels_per_pixel=options.texels_per_pixel,
            margin_texels=float(options.margin_texels),
            search_margin=options.search_margin,
            is_auto=int(plan.is_auto),
            tile_size=plan.tile,
            tiles_per_row=plan.tiles_per_row,
            atlas_size=plan.atlas_size,
            samples_per_batch=plan.samples_per_batch,
            samples_per_chunk=plan.samples_per_chunk,
        )

    @property
    def _near(self) -> float:
        """The near plane of a light that has a place, metres."""
        return max(1e-5 * self._scene.diagonal, 1e-7)

    def _arguments(self, light: Light, keeps_looser_fits: bool) -> bytes:
        """The end of the head, and every chunk's draws: count, instances (filled by the fit), first, base vertex, first
        instance."""
        scene = self._scene
        reaches = reaches_into(scene.geometry.solid_boxes, light, FARTHEST_CORNER * self._near)
        ends = 3 * np.array([0, 0 if reaches else scene.solid_count, scene.opaque_count, scene.triangle_count])
        arguments = np.zeros((DRAWS, DRAW_BYTES // 4), np.uint32)
        arguments[0, 0] = 6
        arguments[1:, 0], arguments[1:, 2] = np.diff(ends), ends[:-1]
        return np.uint32(keeps_looser_fits).tobytes() + np.tile(arguments, (self.plan.chunks, 1)).tobytes()

    def encode_selection(self, commands: Commands, index: int) -> None:
        self.encode_receivers(commands, index)
        with commands.compute("fit") as compute:
            self._fit.dispatch(compute, (self.plan.samples,))

    def encode_receivers(self, commands: Commands, index: int) -> None:
        """Select light `index`: find boxes around what the camera sees and something can shadow."""
        if not self._caches:
            commands.encoder.clear_buffer(self.draws, 0, HEAD_BYTES - 4)
        self.samples.encode(commands.encoder, index)
        self._selection.encode(commands.encoder, index)
        self.receivers.encode(commands)

    def encode_chunk(self, commands: Commands, chunk: int) -> None:
        if self._caches:
            self.encode_draw(commands, chunk)
        else:
            attachment = self._cleared if self.plan.starts_batch(chunk) else self._loaded
            self._encode_draw(commands, chunk, attachment, clears_views=False)

    def encode_draw(self, commands: Commands, chunk: int) -> None:
        """Draw the chunk's occluders into its views, which are cleared one by one."""
        self._encode_draw(commands, chunk, self._loaded, clears_views=True)

    # -- Drawing -------------------------------------------------------------------------------------------------------

    def _encode_draw(
        self, commands: Commands, chunk: int, attachment: Mapping[str, object], *, clears_views: bool
    ) -> None:
        if (chunk, clears_views) not in self._draws:
            self._draws[chunk, clears_views] = self.record_draws(chunk, self._programs, clears_views=clears_views)
        with commands.draw("shadow_maps", color_attachments=[], depth_stencil_attachment=attachment) as draw:
            draw.execute_bundles([self._draws[chunk, clears_views]])

    def draw_programs(self, keeps: str) -> list[DrawProgram]:
        """The programs of a chunk's draws, of which a texel keeps the "greater" or the "less" inverse depth."""
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
                {**self._scene.resources, "light": self.samples.light, "maps": self.settings},
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

    def record_draws(self, chunk: int, programs: Sequence[DrawProgram], *, clears_views: bool) -> wgpu.GPURenderBundle:
        """The chunk's draws, to be replayed every frame: the buffers they name are as old as the maps or the scene."""
        scene, (clear, solid, opaque, masked) = self._scene, programs
        draw = self._gpu.bundle_encoder("depth32float")
        first_view = chunk * self.plan.samples_per_chunk * FACES
        draw.set_vertex_buffer(0, self.draw_views, first_view * dtype(DrawView).itemsize)
        arguments = HEAD_BYTES + DRAW_BYTES * DRAWS * chunk
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
