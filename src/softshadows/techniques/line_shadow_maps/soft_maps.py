"""Soft shadow maps at work on the GPU, for line lights with one number of samples.

line_maps/        rectified maps, drawn in stages
choose.wgsl       after a stage: which samples the next one inserts
skins.wgsl        discontinuities of all maps -> a list of skins and its indirect draw
channels.wgsl     skins drawn into the channels of the neighbouring maps
visibility.wgsl   hard tests and channels -> visibility
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import compose, shader_module
from softshadows.gpu.kernel import Kernel
from softshadows.gpu.layout import F32, U32, Struct, dtype, pack
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext
from softshadows.visibility.line_maps.line_maps import COLUMNS, LineMaps, plan_line_maps

_HERE = Path(__file__).parent
_USAGE = wgpu.BufferUsage
REPORT_WORDS = 4
CONTRADICTION_WORDS = 32
CHANNEL_FORMAT = "rg16float"
BYTES_PER_TEXEL = 8
"""Depth and two channels."""
TEXELS_PER_SKIN = 32
"""Of all maps' texels, so many share a place in the list of skins. The classroom has one in 128."""
TESTED_PIXELS = 32
"""Along the side of a workgroup of the test."""
CLEAR_OFFSET, DRAW_OFFSET, DRAW_BYTES = 0, 16, 32


class Skin(Struct):
    """A discontinuity between a texel of a map and the next in its row, to be drawn into another map.

    `texel` packs column and row, `ends` the face, the sample whose map shows it, and the one it is drawn for.
    """

    texel: U32
    ends: U32
    occluder_closeness: F32
    receiver_closeness: F32


class Control(Struct):
    """The samples in use as bits, in this frame and in the one before; what came of the search for skins."""

    samples: U32
    had_samples: U32
    is_kept: U32
    skins: U32


class Halving(Struct):
    """A test of samples `half_spacing` apart, and the stage that it requests samples for."""

    half_spacing: U32
    stage: U32


@dataclass(frozen=True)
class SoftMapOptions:
    """What the technique's options mean here. With `is_auto`, `samples` is one more than a power of two."""

    samples: int
    is_auto: bool
    tolerance: float
    is_rational: bool
    both_ends_see_all: bool
    looks_for_gaps: bool
    by_ends: bool
    threshold_texels: float
    resolution: int | str
    bias_scale: float
    memory_budget: int


class SoftMaps:
    """The maps, channels and passes; one light at a time."""

    def __init__(self, context: RenderContext, options: SoftMapOptions, report: wgpu.GPUBuffer) -> None:
        self._context, self._options, self._report = context, options, report
        self.gpu = gpu = context.gpu
        gbuffer = context.gbuffer
        # The first stage draws both ends and the middle; each further one halves the spacing.
        self._stages = (options.samples - 1).bit_length() - 1 if options.is_auto else 1
        self.plan = plan_line_maps(
            gpu,
            gbuffer.size,
            options.samples,
            options.resolution,
            options.memory_budget,
            stages=self._stages,
            bytes_per_texel=BYTES_PER_TEXEL,
        )
        self.maps = LineMaps(gpu, context.scene, gbuffer, self.plan, bias_scale=options.bias_scale)
        self._make_resources()
        self._make_kernels()
        self._pipelines = self._make_pipelines()

    def _make_resources(self) -> None:
        gpu, plan, texels = self.gpu, self.plan, self.plan.atlas_size**2
        self._capacity = max(texels // TEXELS_PER_SKIN, 1024)
        self.skins = gpu.storage_buffer(dtype(Skin).itemsize * self._capacity, "the skins")
        self.control = gpu.storage_buffer(dtype(Control).itemsize, "the control words")
        self._contradictions = gpu.storage_buffer(4 * CONTRADICTION_WORDS, "the contradictions")
        self._search, self._draws = (
            gpu.device.create_buffer(size=size, usage=_USAGE.STORAGE | _USAGE.INDIRECT) for size in (16, DRAW_BYTES)
        )
        self.channels = gpu.device.create_texture(
            size=(plan.atlas_size, plan.atlas_size, 1),
            format=CHANNEL_FORMAT,
            usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_SRC,
        )
        self._channels_view = self.channels.create_view()
        self._nearest = gpu.storage_buffer(4 * plan.samples * COLUMNS * plan.tile, "the rows' nearest surfaces")
        buffers = (self._nearest, self.skins, self.control, self._contradictions, self._search, self._draws)
        self.bytes = self.maps.bytes + 4 * texels + sum(buffer.size for buffer in buffers)

    def _make_kernels(self) -> None:
        context, options, maps = self._context, self._options, self.maps
        gpu, gbuffer, looks = context.gpu, context.gbuffer, maps.lookup_resources
        receivers = {0: gbuffer.uniforms, 1: gbuffer.position.create_view(), 2: gbuffer.normal.create_view()}

        def kernel(name: str, entry: str, groups: dict, **constants: float) -> Kernel:
            return Kernel(gpu, _HERE / f"{name}.wgsl", entry, groups, constants)

        self._begin = kernel("choose", "cs_begin", {1: {0: self.control, 2: maps.requests}})
        self._test = kernel("choose", "cs_test", {0: receivers, 2: looks}, knows_rows=options.looks_for_gaps)
        self._choose = kernel("choose", "cs_choose", {2: {1: looks[1]}}, tolerance=options.tolerance)
        self._halvings = [
            self._bind_halving(Halving(half_spacing=(options.samples - 1) >> stage, stage=stage))
            for stage in range(1, self._stages)
        ]
        found = {0: self.control, 1: maps.state, 2: self._draws, 3: self.skins, 4: self._search, 6: self._nearest}
        self._prepare = kernel(
            "skins", "cs_prepare", {1: {k: found[k] for k in (0, 1, 2, 4)}, 2: {k: looks[k] for k in (1, 2)}}
        )
        self._find = kernel(
            "skins",
            "cs_find",
            {1: {k: found[k] for k in (0, 2, 3, 6)}, 2: {k: looks[k] for k in (0, 2, 3, 5)}},
            capacity=self._capacity,
            threshold_texels=options.threshold_texels,
        )
        self._finish = kernel(
            "skins", "cs_finish", {1: {0: self.control, 2: self._draws, 5: self._report}}, capacity=self._capacity
        )
        self._look = kernel(
            "visibility",
            "cs_visibility",
            {
                0: receivers,
                1: {0: self.control, 1: self._channels_view, 2: self._report, 3: self._nearest},
                2: looks,
                3: {0: context.visibility},
            },
            both_ends_see_all=options.both_ends_see_all,
            looks_for_gaps=options.looks_for_gaps,
            by_ends=options.by_ends,
        )

    def _bind_halving(self, halving: Halving) -> tuple[dict[int, wgpu.GPUBindGroup], dict[int, wgpu.GPUBindGroup]]:
        """The kernels' changing bind groups of one test of the samples drawn so far."""
        uniform = self.gpu.device.create_buffer_with_data(data=pack(halving), usage=_USAGE.UNIFORM)
        shared = {0: self.control, 1: self._contradictions, 3: uniform}
        return {1: self._test.bind(1, shared)}, {1: self._choose.bind(1, {**shared, 2: self.maps.requests})}

    def _make_pipelines(self) -> list[tuple[wgpu.GPURenderPipeline, dict[int, wgpu.GPUBindGroup], int]]:
        """What empties the channels and what draws the skins, with bind groups and where their arguments lie."""
        device, looks = self.gpu.device, self.maps.lookup_resources
        module = shader_module(device, compose(_HERE / "channels.wgsl"), "channels.wgsl")
        least = {"src_factor": "one", "dst_factor": "one", "operation": "min"}

        def pipeline(kind: str, target: dict, compare: str, constants: dict[str, float]) -> wgpu.GPURenderPipeline:
            return device.create_render_pipeline(
                layout="auto",
                vertex={"module": module, "entry_point": f"vs_{kind}"},
                primitive={"topology": "triangle-list"},
                depth_stencil={"format": "depth32float", "depth_write_enabled": False, "depth_compare": compare},
                fragment={
                    "module": module,
                    "entry_point": f"fs_{kind}",
                    "targets": [{"format": CHANNEL_FORMAT, **target}],
                    "constants": constants,
                },
            )

        def bind(made: wgpu.GPURenderPipeline, group: int, resources: dict) -> wgpu.GPUBindGroup:
            entries = [
                {"binding": binding, "resource": {"buffer": item} if isinstance(item, wgpu.GPUBuffer) else item}
                for binding, item in resources.items()
            ]
            return device.create_bind_group(layout=made.get_bind_group_layout(group), entries=entries)

        clear = pipeline("clear", {}, "always", {})
        draw = pipeline(
            "skin",
            {"blend": {"color": least, "alpha": least}},
            "greater-equal",
            {"is_rational": self._options.is_rational},
        )
        return [
            (clear, {2: bind(clear, 2, {5: looks[5]})}, CLEAR_OFFSET),
            (draw, {1: bind(draw, 1, {0: self.skins}), 2: bind(draw, 2, dict(looks))}, DRAW_OFFSET),
        ]

    def set_lights(self, lights: Sequence[tuple[Light, int]]) -> None:
        """Write this frame's lights, each with its layer of visibility."""
        last = self._options.samples - 1
        first_stage = {0, last // 2, last} if self._options.is_auto else range(last + 1)
        self.maps.set_lights(lights, sum(1 << sample for sample in first_stage))

    def encode(self, commands: Commands, index: int) -> None:
        """Find light `index`'s visibility."""
        self.maps.encode_receivers(commands, index)
        self.maps.encode_fit(commands)
        with commands.compute("fit") as compute:
            self._begin.begin(compute)
            compute.dispatch_workgroups(1)
        for stage in range(self._stages):
            if stage > 0:
                self._encode_choice(commands, *self._halvings[stage - 1])
            self.maps.encode_maps(commands, stage)
        self._encode_channels(commands)
        width, height = self._context.gbuffer.size
        with commands.compute("lookup") as compute:
            self._look.begin(compute)
            compute.dispatch_workgroups(-(-width // 8), -(-height // 8))
        commands.account(self._options.samples * width * height / self.gpu.lookups_per_ms)

    def _encode_choice(
        self,
        commands: Commands,
        test: dict[int, wgpu.GPUBindGroup],
        choose: dict[int, wgpu.GPUBindGroup],
    ) -> None:
        commands.encoder.clear_buffer(self._contradictions)
        width, height = self._context.gbuffer.size
        with commands.compute("choose") as compute:
            self._test.begin(compute, test)
            compute.dispatch_workgroups(-(-width // TESTED_PIXELS), -(-height // TESTED_PIXELS))
            self._choose.begin(compute, choose)
            compute.dispatch_workgroups(1)

    def _encode_channels(self, commands: Commands) -> None:
        """Skins of all maps, drawn into the channels of their neighbours."""
        with commands.compute("skins") as compute:
            self._prepare.begin(compute)
            compute.dispatch_workgroups(1)
            self._find.begin(compute)
            compute.dispatch_workgroups_indirect(self._search, 0)
            self._finish.begin(compute)
            compute.dispatch_workgroups(1)
        draw = commands.encoder.begin_render_pass(
            color_attachments=[{"view": self._channels_view, "load_op": "load", "store_op": "store"}],
            depth_stencil_attachment={"view": self.maps.atlas.depth_view, "depth_read_only": True},
            timestamp_writes=commands.timer.writes("channels"),
        )
        for pipeline, groups, arguments in self._pipelines:
            draw.set_pipeline(pipeline)
            for group, bindings in groups.items():
                draw.set_bind_group(group, bindings)
            draw.draw_indirect(self._draws, arguments)
        draw.end()
