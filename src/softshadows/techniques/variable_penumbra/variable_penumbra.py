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

from softshadows.gpu.compose import constant
from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques.base import ALL_LIGHTS, Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.light_pass import LightPass, map_source
from softshadows.techniques.options import Choice, choice, one_of, option
from softshadows.techniques.taps import taps, upload_taps
from softshadows.techniques.variable_penumbra.masked import Masked
from softshadows.visibility.maps.shadow_maps import MapOptions

EDGE_NOISE = 1e-4
"""The weakest edge of a fixed mask, as a share of the map's depth. The paper's 0 would take rounding for edges."""
CELL = constant("techniques/variable_penumbra/from_light.wgsl", "CELL")
"""Texels along a cell of the mask."""
SEARCH_MARGIN = 1.0
"""Half lights by which the map reaches beyond the receivers in view: enough for edges at half their distance."""


def mip_level(kernel: int) -> int:
    """The level of the mip chain whose dilation reaches every pixel that a tap of the kernel can tell from its centre.

    A tap of a Poisson disk lies up to kernel / 2 texels from a point anywhere in its texel; level l reaches 2^(l − 1).
    """
    return 1 + max((kernel + 1) // 2 - 1, 0).bit_length()


class Bands(Choice):
    """A kernel for each of three bands of edge strength: the paper's quantised mask."""

    name: ClassVar[str] = "bands"

    sizes: tuple[int, ...] = option(
        default=(3, 5, 7),
        help="taps along the kernel's side in the weakest, the middle and the strongest band",
        low=1,
        high=32,
        entries=(3, 3),
    )
    edges: tuple[float, ...] = option(
        default=(0.2, 0.5, 0.8), help="edge strengths above which the bands begin", low=0.0, high=1000.0, entries=(3, 3)
    )


class Fixed(Choice):
    """One kernel along every edge: the paper's fixed mask."""

    name: ClassVar[str] = "fixed"

    size: int = option(default=4, help="taps along the kernel's side", low=1, high=32)


class FromLight(Choice):
    """Kernels as wide as the penumbra that follows from the light's size and the depths."""

    name: ClassVar[str] = "from_light"

    taps: int = option(default=49, help="taps of a kernel", low=1, high=1024)


class VariablePenumbra(Technique):
    """A shadow map filtered along its edges, wider where the occluder is farther from what lies behind it.

    The presets are the paper's versions: 4x4 and 7x7 with a fixed mask, 2/3/5 and 3/5/7 (the default) with a quantised
    one; `paper` is 3/5/7 with occluders that only cast.
    """

    name: ClassVar[str] = "variable_penumbra"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS
    presets: ClassVar[Presets] = {
        "paper": {"self_shadowing": False},
        "4x4": {"kernels": "fixed", "kernels.size": 4},
        "7x7": {"kernels": "fixed", "kernels.size": 7},
        "2/3/5": {"kernels.sizes": (2, 3, 5)},
        "3/5/7": {},
    }

    kernels: Bands | Fixed | FromLight = choice(
        default=Bands(),
        converter=one_of(Bands, Fixed, FromLight),
        help="filter widths by bands of edge strength, one for all edges, or from the light's size and the depths",
    )
    edge_filter: int = option(default=4, help="neighbours that the edge filter compares a texel with", choices=(4, 8))
    self_shadowing: bool = option(
        default=True, help="whether closed solids receive shadows, or only cast them", choices=(True, False)
    )
    layers: int = option(
        default=1, help="of the map: with 2, edges before other surfaces do not choose a pixel's kernel", choices=(1, 2)
    )
    resolution: int | str = resolution_option(1024)

    def build(self, context: RenderContext) -> TechniquePass:
        if isinstance(self.kernels, FromLight):
            return self._build_from_light(context, self.kernels.taps)
        return self._build_bands(context, self.kernels)

    def _build_bands(self, context: RenderContext, chosen: Bands | Fixed) -> TechniquePass:
        kernels = chosen.sizes if isinstance(chosen, Bands) else (chosen.size,) * 3
        edges = chosen.edges if isinstance(chosen, Bands) else (EDGE_NOISE,) * 3
        levels = [mip_level(kernel) for kernel in kernels]
        cell_bits = min(levels) - 1
        constants: dict[str, float] = {"cell_bits": cell_bits}
        for band, kernel, edge, level in zip(("blue", "green", "red"), kernels, edges, levels, strict=True):
            constants |= {f"{band}_kernel": kernel, f"{band}_edge": edge, f"{band}_level": level}
        maps = map_source(context, self.resolution, MapOptions(margin_texels=3 << max(levels) - 1))
        masked = Masked(
            context,
            "techniques/variable_penumbra/bands.wgsl",
            constants=constants | self._edge_constants,
            layers=self.layers,
            taps=upload_taps(context.gpu, *(taps("poisson", kernel**2) for kernel in kernels)),
            most_lookups=max(kernels) ** 2,
            mask_bytes=4 * (((maps.plan(1).atlas_size - 1) >> cell_bits) + 1) ** 2,
            mask_reads=1,
        )
        return LightPass(context, Sampling(center_sample, ignores_size=True), maps, masked)

    def _build_from_light(self, context: RenderContext, count: int) -> TechniquePass:
        maps = map_source(context, self.resolution, MapOptions(margin_texels=2, search_margin=SEARCH_MARGIN))
        masked = Masked(
            context,
            "techniques/variable_penumbra/from_light.wgsl",
            constants={"tap_count": count} | self._edge_constants,
            layers=self.layers,
            taps=upload_taps(context.gpu, taps("grid", count)),
            most_lookups=count,
            mask_bytes=8 * self.layers * ((maps.plan(1).atlas_size - 1) // CELL + 1) ** 2,
            mask_reads=4,
        )
        return LightPass(context, Sampling(center_sample), maps, masked)

    @property
    def _edge_constants(self) -> dict[str, float]:
        return {"neighbours": self.edge_filter, "self_shadowing": self.self_shadowing}
