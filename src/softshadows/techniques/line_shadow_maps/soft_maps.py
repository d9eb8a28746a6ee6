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

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.layout import F32, U32, Struct, dtype, pack
from softshadows.gpu.program import DrawProgram, Program, Resource, view_of
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext
from softshadows.visibility.line_maps.line_maps import COLUMNS, LineMaps, plan_line_maps

_FOLDER = "techniques/line_shadow_maps"
_USAGE = wgpu.BufferUsage
REPORT_WORDS = 1 + constant(f"{_FOLDER}/skins.wgsl", "DROPPED")
CONTRADICTION_WORDS = 1 + constant(f"{_FOLDER}/choose.wgsl", "TESTED")
CHANNEL_FORMAT = "rg16float"
BYTES_PER_TEXEL = 8
"""Depth and two channels."""
TEXELS_PER_SKIN = 32
"""How many of all maps' texels share a place in the list of skins. The classroom has one in 128 at 1024×768."""
FEWEST_SKINS = 1 << 18
"""Places in the list at least, 4 MiB: small maps have more skins per texel. Those beyond the list are left out as their
threads come, so that no two frames are alike; atrium and classroom at 96×72 have 125 000."""
TESTED_PIXELS = 8 * constant(f"{_FOLDER}/choose.wgsl", "PIXEL_STEP")
"""Along the side of a workgroup of the test."""
TOLERANCE = 1e-4
"""The share of pixels with contradictions that auto accepts. Measured: docs/decisions/0013-line-shadow-maps.md."""
THRESHOLD_TEXELS = 1.0
"""The least depth of a discontinuity, in texels of its distance."""
CLEAR_OFFSET, DRAW_OFFSET = (4 * constant(f"{_FOLDER}/skins.wgsl", name) for name in ("CLEAR", "DRAW"))
DRAW_BYTES = 16
"""Bytes of one draw's arguments."""
_QUADS = {"topology": "triangle-list"}
_LEAST = {"src_factor": "one", "dst_factor": "one", "operation": "min"}


class Skin(Struct):
    """A discontinuity between a texel of a map and the next in its row, to be drawn into another map.

    `texel` packs column and row, `ends` the face, the sample whose map shows it, and the one it is drawn for.
    """

    texel: U32
    ends: U32
    occluder_inverse_depth: F32
    receiver_inverse_depth: F32


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
    is_rational: bool
    both_ends_see_all: bool
    looks_for_gaps: bool
    by_ends: bool
    resolution: int | str


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
            context.memory_budget,
            stages=self._stages,
            bytes_per_texel=BYTES_PER_TEXEL,
        )
        self.maps = LineMaps(gpu, context.scene, gbuffer, self.plan)
        self._make_buffers()
        self._make_programs()

    def _make_buffers(self) -> None:
        gpu, plan, texels = self.gpu, self.plan, self.plan.atlas_size**2
        self._capacity = max(texels // TEXELS_PER_SKIN, FEWEST_SKINS)
        self.skins = gpu.storage_buffer(dtype(Skin).itemsize * self._capacity, "the skins")
        self.control = gpu.storage_buffer(dtype(Control).itemsize, "the control words")
        self._contradictions = gpu.storage_buffer(4 * CONTRADICTION_WORDS, "the contradictions")
        indirect = _USAGE.STORAGE | _USAGE.INDIRECT
        self._search = gpu.buffer(16, indirect, "the dispatch of the search for skins")
        self._draws = gpu.buffer(2 * DRAW_BYTES, indirect, "the draws of the skins")
        self._nearest = gpu.storage_buffer(4 * plan.samples * COLUMNS * plan.tile, "the rows' nearest surfaces")
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_SRC
        self.channels = gpu.texture((plan.atlas_size, plan.atlas_size), CHANNEL_FORMAT, usage, "the channels")
        self._channels_view = view_of(self.channels)
        self._halvings = [
            self._halving(Halving(half_spacing=(self._options.samples - 1) >> stage, stage=stage))
            for stage in range(1, self._stages)
        ]
        buffers = (self._nearest, self.skins, self.control, self._contradictions, self._search, self._draws)
        self.bytes = self.maps.bytes + 4 * texels + sum(buffer.size for buffer in buffers)

    def _halving(self, halving: Halving) -> wgpu.GPUBuffer:
        buffer = self.gpu.storage_buffer(dtype(Halving).itemsize, "a halving")
        self.gpu.write(buffer, 0, pack(halving), what="constant")
        return buffer

    def _make_programs(self) -> None:
        """In the order in which they run."""
        self._make_choices()
        self._make_channels()
        options = self._options
        self._look = self._program(
            "visibility",
            "cs_visibility",
            {
                **self._context.gbuffer.resources,
                "control": self.control,
                "channels": self._channels_view,
                "report": self._report,
                "nearest_in_row": self._nearest,
                "visibility": self._context.visibility,
            },
            both_ends_see_all=options.both_ends_see_all,
            looks_for_gaps=options.looks_for_gaps,
            by_ends=options.by_ends,
        )

    def _program(self, file: str, entry: str, resources: dict[str, Resource], **constants: float) -> Program:
        """One that looks into the maps."""
        used = {**self.maps.resources, **resources}
        return Program(self.gpu, f"{_FOLDER}/{file}.wgsl", entry, used, constants=constants)

    def _make_choices(self) -> None:
        """What finds out which samples are in use."""
        options = self._options
        used: dict[str, Resource] = {
            **self._context.gbuffer.resources,
            "control": self.control,
            "contradictions": self._contradictions,
            "requests": self.maps.requests,
        }
        self._begin, test, choose = (
            self._program("choose", entry, used, knows_rows=options.looks_for_gaps, tolerance=TOLERANCE)
            for entry in ("cs_begin", "cs_test", "cs_choose")
        )
        self._tests = [(test, test.bind(halving=halving)) for halving in self._halvings]
        self._choices = [(choose, choose.bind(halving=halving)) for halving in self._halvings]

    def _make_channels(self) -> None:
        """What finds the skins and draws them."""
        options = self._options
        used: dict[str, Resource] = {
            "control": self.control,
            "state": self.maps.state,
            "draws": self._draws,
            "skins": self.skins,
            "search": self._search,
            "report": self._report,
            "nearest_in_row": self._nearest,
        }
        self._prepare, self._find, self._finish = (
            self._program("skins", entry, used, capacity=self._capacity, threshold_texels=THRESHOLD_TEXELS)
            for entry in ("cs_prepare", "cs_find", "cs_finish")
        )
        self._clear_channels = self._draw_program("clear", {}, "always")
        least = {"blend": {"color": _LEAST, "alpha": _LEAST}}
        self._draw_skins = self._draw_program("skin", least, "greater-equal", is_rational=options.is_rational)

    def _draw_program(self, kind: str, target: dict, compare: str, **constants: float) -> DrawProgram:
        """What draws into the channels, behind the maps' surfaces as `compare` says."""
        depth = {"format": "depth32float", "depth_write_enabled": False, "depth_compare": compare}
        return DrawProgram(
            self.gpu,
            f"{_FOLDER}/channels.wgsl",
            f"vs_{kind}",
            f"fs_{kind}",
            {**self.maps.resources, "skins": self.skins},
            state={"primitive": _QUADS, "depth_stencil": depth},
            targets=[{"format": CHANNEL_FORMAT, **target}],
            constants=constants,
        )

    @property
    def can_cache(self) -> bool:
        """Can maps and channels stay from frame to frame, where one light has them to itself?"""
        return True

    def write(self, lights: Sequence[tuple[Light, int]], *, keeps_looser_fits: bool) -> None:
        """Write this frame's lights, each with its layer of visibility."""
        last = self._options.samples - 1
        first_stage = {0, last // 2, last} if self._options.is_auto else range(last + 1)
        requested = sum(1 << sample for sample in first_stage)
        self.maps.write(lights, requested, keeps_looser_fits=keeps_looser_fits)

    def encode(self, commands: Commands, index: int) -> None:
        """Find light `index`'s visibility."""
        self.maps.encode_receivers(commands, index)
        self.maps.encode_fit(commands)
        with commands.compute("fit") as compute:
            self._begin.dispatch(compute, (1,))
        for stage in range(self._stages):
            if stage > 0:
                self._encode_choice(commands, stage - 1)
            self.maps.encode_maps(commands, stage)
        self._encode_channels(commands)
        width, height = self._context.gbuffer.size
        with commands.compute("lookup") as compute:
            self._look.dispatch(compute, (-(-width // 8), -(-height // 8)))
        commands.account(self._options.samples * width * height / self.gpu.budget.lookups_per_ms)

    def _encode_choice(self, commands: Commands, number: int) -> None:
        """Test the samples drawn so far, and request those of the next stage."""
        commands.encoder.clear_buffer(self._contradictions)
        width, height = self._context.gbuffer.size
        (test, tested), (choose, chosen) = self._tests[number], self._choices[number]
        with commands.compute("choose") as compute:
            test.dispatch(compute, (-(-width // TESTED_PIXELS), -(-height // TESTED_PIXELS)), tested)
            choose.dispatch(compute, (1,), chosen)

    def _encode_channels(self, commands: Commands) -> None:
        """Skins of all maps, drawn into the channels of their neighbours."""
        with commands.compute("skins") as compute:
            self._prepare.dispatch(compute, (1,))
            self._find.dispatch_indirect(compute, self._search)
            self._finish.dispatch(compute, (1,))
        color = {"view": self._channels_view, "load_op": "load", "store_op": "store"}
        depth = {"view": self.maps.atlas.depth_view, "depth_read_only": True}
        with commands.draw("channels", color_attachments=[color], depth_stencil_attachment=depth) as draw:
            self._clear_channels.begin(draw)
            draw.draw_indirect(self._draws, CLEAR_OFFSET)
            self._draw_skins.begin(draw)
            draw.draw_indirect(self._draws, DRAW_OFFSET)
