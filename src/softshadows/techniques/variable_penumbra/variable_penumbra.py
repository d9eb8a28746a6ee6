"""Variable penumbra for weak devices: edges of one shadow map say where it is filtered, and how wide.

Where no edge is near, a pixel costs one read of the mask and one of the map. `kernels="bands"` is the paper: edges are
sorted by strength into three bands with kernels of fixed size. `kernels="from_light"` keeps the idea and replaces the
bands: each edge tells the pixels that its penumbra reaches how near the occluder is, and width follows from that and
the light's size. `layers=2` knows of each texel whether something lies behind its nearest surface, and lets a pixel's
kernel follow only the edges that bound the shadow on it.

Paper
    [Evans2014]      Evans, Agenjo, Blat, "Variable Penumbra Soft Shadows for Mobile Devices", GRAPP 2014.
    [Fernando2005]   Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH 2005 sketches.

Section map
    [Evans2014 Eq. 1]   five taps find an edge                  -> bands.wgsl edge_strength()
    [Evans2014 Eq. 2]   nine taps find an edge                  -> bands.wgsl edge_strength()
    [Evans2014 §4.3]    the mask: dilated edges, PCF inside     -> bands.wgsl dilate(), masked_shadow()
    [Evans2014 §4.4]    bands of strength, a kernel for each    -> bands.wgsl band_of(), kernel_of()
    [Evans2014 §5]      Z-peeling, the paper's future work      -> edges.wgsl layer_of(); last_layer.py
    [Fernando2005 §penumbra estimation]  width from the light   -> light_filter.wgsl penumbra_half_extent()

Departures from the paper
    - Depth runs from the map's nearest surface to its farthest, found on the GPU; the paper leaves its range open. A
      lone occluder is therefore always as far as can be, and bands may move with what is in view.
    - No mip chain is built. An edge sets the texels of the dilated mask that the chain would give, exactly: what a
      bilinear fetch of a level with clamped values sees is known beforehand. Each band has its own level, the lowest
      that covers its kernel.
    - Filter (2) is divided by three, so that a straight edge answers alike to both.
    - "Mask is 0.0 ... apply PCF" is read as "> 0"; of several bands the strongest counts; a fixed mask starts at
      EDGE_NOISE instead of 0.
    - Taps compare with the receiver's plane, and hard pixels are those of `hard` (docs/decisions/0002-bias.md).
    - `self_shadowing` is on. Off as in the paper, closed solids cast and do not receive.
    - Of the surfaces that Z-peeling would find, `layers=2` keeps the nearest and the last: an edge before the last
      surface concerns pixels on it, any other edge those before it. Internal edges then leave the floor's kernels
      alone; rmse of `from_light` falls by a tenth in `figures` and `leaves`, by 4 % in `sphere_cube`.
    - `from_light` is no part of the paper: figures in docs/decisions/0014-variable-penumbra.md.

Use when
    texture reads are what a device lacks, and shadows need only look plausible (`bands`), or should also have about
    the right width (`from_light`).
Fails when
    the paper's kernels meet any light: widths are texels of the map, at most three of them, jump between bands and
    ignore the light's size (scene `blocker`). An edge within the model's outline puts a wrong kernel in patches, unless
    `layers=2`; so does a coarse map. `from_light` mixes occluders at different heights into one (scene `sphere_cube`:
    light leaks into umbrae), knows only what the light's centre sees (scene `fence`), and shades creases where a cone
    or a wheel meets the floor (scene `figures`).
Inputs
    any light; bands take it as its centre, `from_light` filters nothing under a light without size.
Cost
    one shadow map, drawn twice with `layers=2`, two passes over its texels with six (filter 4) or ten (filter 8) reads
    in all, then two reads per pixel (five `from_light`), and near edges as many more as the kernel has taps.
    `frame.stats.lookups_per_pixel` is counted on the GPU: the mean over the pixels that look into the map.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.techniques.base import ALL_LIGHTS, Presets, RenderContext, Technique, TechniquePass, option
from softshadows.techniques.common_options import DEFAULT_MEMORY_BUDGET, resolution_option
from softshadows.techniques.taps import PATTERNS, taps, upload_taps
from softshadows.techniques.variable_penumbra.masked_pass import MaskedPass
from softshadows.visibility.maps.plan import plan_atlas

EDGE_NOISE = 1e-4
"""Of the map's depth: the weakest edge of a fixed mask. The paper's 0 would take rounding for edges."""
CELL = 8
"""Texels along a cell of from_light.wgsl."""
SEARCH_MARGIN = 1.0
"""Half lights by which the map reaches beyond the receivers in view: enough for edges at half their distance."""


def mip_level(kernel: int, pattern: str) -> int:
    """The level of the mip chain whose dilation reaches every pixel that a tap of the kernel can tell from its centre.

    A tap of a grid lies up to (kernel − 1) / 2 texels from a point anywhere in its texel, one of a Poisson disk up to
    kernel / 2; level l reaches 2^(l − 1) texels.
    """
    reach = kernel // 2 if pattern == "grid" else (kernel + 1) // 2
    return 1 + max(reach - 1, 0).bit_length()


class VariablePenumbra(Technique):
    """A shadow map filtered along its edges, wider where the occluder is farther from what lies behind it.

    `VariablePenumbra.preset("2/3/5")` gives the paper's versions: 4x4 and 7x7 with a fixed mask, 2/3/5 and 3/5/7 (the
    default) with a quantised one.
    """

    name: ClassVar[str] = "variable_penumbra"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS
    presets: ClassVar[Presets] = {
        "4x4": {"mask": "fixed", "kernel": 4},
        "7x7": {"mask": "fixed", "kernel": 7},
        "2/3/5": {"blue_kernel": 2, "green_kernel": 3, "red_kernel": 5},
        "3/5/7": {},
    }

    kernels: str = option(
        default="bands",
        help="filter widths by bands of edge strength, or from the light's size and the depths",
        choices=("bands", "from_light"),
    )
    mask: str = option(
        default="quantised", help="three bands, or one kernel along every edge", choices=("quantised", "fixed")
    )
    kernel: int = option(default=4, help="taps along the kernel's side with a fixed mask", low=1, high=32)
    blue_kernel: int = option(default=3, help="taps along the kernel's side in the weakest band", low=1, high=32)
    green_kernel: int = option(default=5, help="taps along the kernel's side in the middle band", low=1, high=32)
    red_kernel: int = option(
        default=7, help="taps along the kernel's side in the strongest band, and from the light", low=1, high=32
    )
    blue_edge: float = option(default=0.2, help="edge strength above which the blue band begins", low=0.0, high=10.0)
    green_edge: float = option(default=0.5, help="edge strength above which the green band begins", low=0.0, high=10.0)
    red_edge: float = option(default=0.8, help="edge strength above which the red band begins", low=0.0, high=10.0)
    edge_filter: int = option(default=4, help="neighbours that the edge filter compares a texel with", choices=(4, 8))
    edge_scale: float = option(default=1.0, help="factor on the edge strength", low=0.0, high=1000.0)
    pattern: str = option(
        default="poisson", help="taps of a band in a Poisson disk, or a square grid", choices=PATTERNS
    )
    self_shadowing: bool = option(
        default=True, help="whether closed solids receive shadows, or only cast them", choices=(True, False)
    )
    layers: int = option(
        default=1, help="of the map: with 2, edges before other surfaces do not choose a pixel's kernel", choices=(1, 2)
    )
    resolution: int | str = resolution_option(1024)

    def build(self, context: RenderContext) -> TechniquePass:
        plan = plan_atlas(context.gpu, context.scene, context.gbuffer.size, 1, self.resolution, DEFAULT_MEMORY_BUDGET)
        build = self._build_from_light if self.kernels == "from_light" else self._build_bands
        return build(context, plan.atlas_size)

    def _build_bands(self, context: RenderContext, atlas_size: int) -> TechniquePass:
        is_fixed = self.mask == "fixed"
        kernels = [self.kernel] * 3 if is_fixed else [self.blue_kernel, self.green_kernel, self.red_kernel]
        edges = [EDGE_NOISE] * 3 if is_fixed else [self.blue_edge, self.green_edge, self.red_edge]
        levels = [mip_level(kernel, self.pattern) for kernel in kernels]
        cell_bits = min(levels) - 1
        constants = {"edge_scale": self.edge_scale, "cell_bits": cell_bits}
        for band, kernel, edge, level in zip(("blue", "green", "red"), kernels, edges, levels, strict=True):
            constants |= {f"{band}_kernel": kernel, f"{band}_edge": edge, f"{band}_level": level}
        return MaskedPass(
            context,
            "techniques/variable_penumbra/bands.wgsl",
            resolution=self.resolution,
            largest_lookups=max(kernels) ** 2,
            constants=constants | self._edge_constants,
            taps=upload_taps(context.gpu, *(taps(self.pattern, kernel**2) for kernel in kernels)),
            layers=self.layers,
            mask_bytes=4 * (((atlas_size - 1) >> cell_bits) + 1) ** 2,
            mask_reads=1,
            takes_center_only=True,
            margin_texels=3 << max(levels) - 1,
            search_margin=0.0,
        )

    def _build_from_light(self, context: RenderContext, atlas_size: int) -> TechniquePass:
        count = self.red_kernel**2
        return MaskedPass(
            context,
            "techniques/variable_penumbra/from_light.wgsl",
            resolution=self.resolution,
            largest_lookups=count,
            constants={"tap_count": count} | self._edge_constants,
            taps=upload_taps(context.gpu, taps("grid", count)),
            layers=self.layers,
            mask_bytes=8 * self.layers * ((atlas_size - 1) // CELL + 1) ** 2,
            mask_reads=4,
            takes_center_only=False,
            margin_texels=2,
            search_margin=SEARCH_MARGIN,
        )

    @property
    def _edge_constants(self) -> dict[str, float]:
        return {"neighbours": self.edge_filter, "self_shadowing": self.self_shadowing}
