"""Percentage-closer filtering: a hard shadow map, compared at several texels and averaged.

Paper
    [Reeves1987]  Reeves, Salesin, Cook, "Rendering Antialiased Shadows with Depth Maps", SIGGRAPH 1987.

Section map
    [Reeves1987 §3]   comparisons averaged, not depths   -> pcf.wgsl filter_shadow()

Departures from the paper
    - A fixed number of taps in texels of the map instead of a jittered region of the pixel's footprint.
    - Every tap compares with the receiver's plane at that texel, so a wider kernel needs no larger bias.

Use when
    jagged edges of a hard shadow are to be softened by a few texels.
Fails when
    the penumbra should grow with the occluder's distance: its width is the kernel's, everywhere (scene `blocker`).
Inputs
    any light, taken as its centre.
Cost
    one shadow map, kernel² look-ups per pixel.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.light_pass import LightPass, Lookups, map_source
from softshadows.techniques.options import option
from softshadows.techniques.taps import PATTERNS, taps, upload_taps
from softshadows.visibility.maps.shadow_maps import MapOptions


class Pcf(Technique):
    """A hard shadow map with kernel×kernel comparisons `spread` texels apart."""

    name: ClassVar[str] = "pcf"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS

    kernel: int = option(default=4, help="taps along each side of the kernel", low=1, high=32)
    spread: float = option(default=1.0, help="texels between taps", low=0.0, high=64.0)
    pattern: str = option(default="grid", help="a square grid, or as many taps in a Poisson disk", choices=PATTERNS)
    resolution: int | str = resolution_option(1024)

    def build(self, context: RenderContext) -> TechniquePass:
        half_kernel = self.kernel * self.spread / 2.0
        maps = map_source(context, self.resolution, MapOptions(margin_texels=int(half_kernel) + 2))
        return LightPass(context, Sampling(center_sample, ignores_size=True), maps, self.filtered(context))

    def filtered(self, context: RenderContext) -> Lookups:
        """The share of lit texels around the receiver's."""
        count = self.kernel**2
        return Lookups(
            context,
            "techniques/pcf/pcf.wgsl",
            per_pixel=lambda _: float(count),
            resources={"taps": upload_taps(context.gpu, taps(self.pattern, count))},
            constants={"tap_count": count, "half_kernel_texels": self.kernel * self.spread / 2.0},
        )
