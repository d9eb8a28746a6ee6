"""Hard shadows: one shadow map from the light's centre, one test per pixel.

Paper
    [Williams1978]  Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978.

Section map
    [Williams1978]   depth of the first surface along the light's rays, compared  -> shadow_map.wgsl sample_is_visible()

Departures from the paper
    - The comparison takes place on the ray through the texel's centre, against the receiver's own plane, so that no
      surface shadows itself; the paper suggests a constant bias. See docs/decisions/0002-bias.md for the measured
      effect.

Use when
    the light is tiny or far away, or as the cheapest baseline.
Fails when
    the light has any size: there is no penumbra (every scene of softshadows shows it).
Inputs
    any light, taken as its centre.
Cost
    one shadow map, one look-up per pixel.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.light_pass import LightPass, Lookups, map_source


class Hard(Technique):
    """A hard shadow from the light's centre."""

    name: ClassVar[str] = "hard"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS

    resolution: int | str = resolution_option(1024)

    def build(self, context: RenderContext) -> TechniquePass:
        maps = map_source(context, self.resolution)
        average = Lookups(context, "techniques/uniform/uniform.wgsl")  # over a single sample
        return LightPass(context, Sampling(center_sample, ignores_size=True), maps, average)
