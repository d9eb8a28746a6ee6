"""Variance shadow maps: a filtered map of depth and squared depth, and an upper bound on visibility from it.

Paper
    [Donnelly2006]  Donnelly, Lauritzen, "Variance Shadow Maps", I3D 2006.

Section map
    [Donnelly2006 §3]      moments of depth, filtered         -> vsm.wgsl cs_filter_rows(), cs_filter_columns()
    [Donnelly2006 Eq. 5]   Chebyshev's inequality             -> vsm.wgsl upper_bound()

Departures from the paper
    - Moments are 32-bit floats of linear depth, so no precision is lost to the map.
    - Light-bleed reduction after Lauritzen's later work cuts the bound's tail; 0 gives the paper.

Use when
    a cheap, smooth, prefiltered edge is wanted over a single receiver.
Fails when
    occluders overlap: the bound is not tight and light bleeds into the umbra (scene `sphere_cube`). Its penumbra has
    the filter's width, whatever the light's size.
Inputs
    any light, taken as its centre.
Cost
    one shadow map, two filters of kernel taps per texel, four reads per pixel.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.gpu.commands import Commands
from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.light_pass import ChunkPrograms, Combination, LightPass, map_source
from softshadows.techniques.options import option
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps

MIN_VARIANCE = 1e-7
"""The least variance, as a share of the light's reach squared: a standard deviation of 0.03 %, a receiver's slope
within a texel."""


class Vsm(Technique):
    """A variance shadow map filtered by a box of kernel×kernel texels."""

    name: ClassVar[str] = "vsm"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS

    kernel: int = option(
        default=5, help="texels along each side of the box filter; even numbers round up", low=1, high=63
    )
    light_bleed_reduction: float = option(default=0.2, help="share of the bound's tail that is cut", low=0.0, high=0.95)
    resolution: int | str = resolution_option(1024, high=8192)

    def build(self, context: RenderContext) -> TechniquePass:
        maps = map_source(context, self.resolution, MapOptions(margin_texels=self.kernel // 2 + 2))
        combination = _FilteredMoments(context, self, maps.plan(1).atlas_size)
        return LightPass(context, Sampling(center_sample, ignores_size=True), maps, combination)


class _FilteredMoments(Combination[ShadowMaps]):
    """The map's moments, filtered along rows and columns, and the bound that they give."""

    def __init__(self, context: RenderContext, technique: Vsm, atlas_size: int) -> None:
        super().__init__(context)
        what = "the moments of a variance shadow map"
        self._rows, self._moments = (context.gpu.storage_buffer(8 * atlas_size**2, what) for _ in range(2))
        self._programs = ChunkPrograms(
            context,
            "techniques/vsm/vsm.wgsl",
            "cs_filter_rows",
            "cs_filter_columns",
            "cs_visibility",
            resources={"row_moments": self._rows, "moments": self._moments},
            constants={
                "kernel_radius": technique.kernel // 2,
                "light_bleed_reduction": technique.light_bleed_reduction,
                "min_variance": MIN_VARIANCE,
            },
        )

    @property
    def bytes(self) -> int:
        return self._rows.size + self._moments.size

    def lookups(self, samples: int) -> float:
        return 4.0

    def encode(self, commands: Commands, provider: ShadowMaps, chunk: int) -> None:
        groups, run = -(-provider.plan.atlas_size // 8), self._programs.encode
        run(commands, "moments", "cs_filter_rows", provider, chunk, groups=(groups, groups))
        run(commands, "moments", "cs_filter_columns", provider, chunk, groups=(groups, groups))
        run(commands, "lookup", "cs_visibility", provider, chunk)
