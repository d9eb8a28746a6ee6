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
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.options import option
from softshadows.techniques.sampled import SampledPass, center_sample
from softshadows.visibility.maps.plan import plan_atlas
from softshadows.visibility.maps.shadow_atlas import ShadowAtlas

MIN_VARIANCE = 1e-7
"""Of the light's reach squared: a standard deviation of 0.03 %, the slope of a receiver within a texel."""


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
        return _VsmPass(context, self)


class _VsmPass(SampledPass):
    def __init__(self, context: RenderContext, technique: Vsm) -> None:
        gpu, size = context.gpu, context.gbuffer.size
        plan = plan_atlas(gpu, context.scene, size, 1, technique.resolution, context.memory_budget)
        bytes = 8 * plan.atlas_size**2
        rows, moments = (gpu.storage_buffer(bytes, "the moments of a variance shadow map") for _ in range(2))
        super().__init__(
            context,
            "techniques/vsm/vsm.wgsl",
            samples_of=center_sample,
            takes_center_only=True,
            resolution=technique.resolution,
            lookups=lambda _: 4.0,
            constants={
                "kernel_radius": technique.kernel // 2,
                "light_bleed_reduction": technique.light_bleed_reduction,
                "min_variance": MIN_VARIANCE,
            },
            resources={"row_moments": rows, "moments": moments},
            margin_texels=technique.kernel // 2 + 2,
        )

    def _encode_lookups(self, commands: Commands, atlas: ShadowAtlas, chunk: int) -> None:
        groups = -(-atlas.plan.atlas_size // 8)
        self._dispatch(commands, atlas, chunk, "cs_filter_rows", "moments", (groups, groups))
        self._dispatch(commands, atlas, chunk, "cs_filter_columns", "moments", (groups, groups))
        super()._encode_lookups(commands, atlas, chunk)
