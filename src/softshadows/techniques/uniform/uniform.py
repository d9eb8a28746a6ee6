"""Uniform light sampling: one hard shadow map for every point of a grid on the light, averaged.

Paper
    [Schwaerzler2012]  Schwärzler, Mattausch, Scherzer, Wimmer, "Fast Accurate Soft Shadows with Adaptive Light Source
    Sampling", VMV 2012: the fixed sampling that the paper measures itself against.

Section map
    [Schwaerzler2012 Eq. 2]   share of the visible samples   -> uniform.wgsl cs_visibility()

Departures from the paper
    - `weights="trapezoid"` is the default. On a grid that touches the light's border, the paper's equal weights count
      the border twice as much as its area deserves: on a half plane parallel to the light the largest error is 1/17
      with 17×17 samples, and 1/32 with trapezoid weights. `weights="equal"` is the paper's.
    - Shadow maps are fitted to what the camera sees and cut into cube faces, so that no receiver falls outside, and
      store reciprocal depth; see docs/decisions/0001-shadow-maps.md. `resolution=512` gives the paper's map size.
    - `visibility="ray"` traces a ray to each sample instead of looking into a map, and agrees with Embree pixel by
      pixel; "hybrid" does so only where the four texels around a look-up do not agree. See docs/decisions/0017-rays.md.
    - Samples below a receiver's horizon count as invisible.
    - With `visibility="ray"`, `visibility.offsets=stratified` asks about other points in each of 4×4 pixels, and
      `visibility.denoise` averages them, where penumbrae are wider than a few pixels: `grid=5` on scorpion errs by
      0.0062 instead of 0.0083. The offsets alone add noise (0.0147). Measured: docs/decisions/0017-rays.md.

Use when
    you need a dependable soft shadow and time does not matter: the more samples, the closer to the truth.
Fails when
    the penumbra is wider on screen than twice the number of samples along the light in pixels: bands show (scene
    `blocker`, seen from near). Occluders thinner than a texel of the shadow map break up (scene `fence` with a low
    `resolution`).
Inputs
    rectangle, disk and line lights; lights without size take one sample.
Cost
    grid² shadow maps (grid for a line) and as many look-ups per pixel.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from softshadows.lights.grid import WEIGHTS, grid_samples
from softshadows.lights.jitter import placed, strata_of
from softshadows.lights.sample_sets import Samples, Sampling
from softshadows.scene.lights import Light
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import (
    VISIBILITIES,
    VISIBILITY_HELP,
    Hybrid,
    Maps,
    Rays,
    check_resolution,
    resolution_option,
)
from softshadows.techniques.light_pass import LightPass, Lookups, map_source
from softshadows.techniques.options import choice, option
from softshadows.techniques.uniform.traced_share import TracedShare
from softshadows.visibility.maps.shadow_maps import MapOptions
from softshadows.visibility.sources import HybridSource, RaySource

NOISE_COLUMNS = 1.5
"""How far visibility may be off: an edge along a side of the light meets a column of samples at once. Measured:
docs/decisions/0017-rays.md."""


class Uniform(Technique):
    """Average of grid×grid hard shadows; 17 gives the paper's 289 maps. The module's text is its manual."""

    name: ClassVar[str] = "uniform"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS
    refines: ClassVar[bool] = True

    grid: int = option(default=17, help="light samples along each side of the light", low=1, high=64)
    weights: str = option(
        default="trapezoid",
        help="how samples are weighted: by the trapezoid rule on a grid that touches the light's border; equally on "
        "that grid, as in the paper; equally in the middle of grid×grid cells",
        choices=WEIGHTS,
    )
    visibility: Maps | Rays | Hybrid = choice(default=Maps(), converter=VISIBILITIES, help=VISIBILITY_HELP)
    resolution: int | str = resolution_option("auto")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_resolution(self.name, self.visibility, self.resolution)

    def build(self, context: RenderContext) -> TechniquePass:
        sampling = Sampling(self._samples)
        noise = min(NOISE_COLUMNS / max(self.grid - 1, 1), 1.0) if self._rays.denoise else None
        if isinstance(self.visibility, Rays):
            places = strata_of(self._rays.offsets)
            rays = RaySource(context.gpu, context.scene, context.gbuffer, places)
            return LightPass(context, sampling, rays, TracedShare(context, rays, noise))
        is_hybrid = isinstance(self.visibility, Hybrid)
        most_per_chunk = context.gpu.budget.rays_at_once if is_hybrid else None
        maps = map_source(context, self.resolution, MapOptions(caches=True), most_per_chunk)
        if is_hybrid:
            hybrid = HybridSource(maps)
            return LightPass(context, sampling, hybrid, TracedShare(context, hybrid, noise))
        return LightPass(context, sampling, maps, Lookups(context, "techniques/uniform/uniform.wgsl"))

    @property
    def _rays(self) -> Rays:
        return self.visibility if isinstance(self.visibility, Rays) else Rays()

    def _samples(self, light: Light, jitter: int) -> Samples:
        def points_at(shift: tuple[float, float]) -> np.ndarray:
            return grid_samples(light, self.grid, self.weights, shift)[0]

        weights = grid_samples(light, self.grid, self.weights)[1]
        return placed(points_at, jitter, self._rays.offsets), weights
