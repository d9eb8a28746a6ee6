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
    - With `visibility="ray"`, `offsets="stratified"` asks about other points in each of 4×4 pixels, and `denoise`
      averages them, where penumbrae are wider than a few pixels: `grid=5` on scorpion errs by 0.0062 instead of 0.0083.
      The offsets alone add noise (0.0147). Measured: docs/decisions/0017-rays.md.

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

from softshadows.lights.jitter import moved, placed, places_of
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
from softshadows.techniques.options import choice, option
from softshadows.techniques.sampled import SampledPass, Samples
from softshadows.techniques.traced import TracedPass

WEIGHTS = ("trapezoid", "equal", "midpoint")
NOISE_COLUMNS = 1.5
"""How far visibility may be off: an edge along a side of the light meets a column of samples at once. Measured:
docs/decisions/0017-rays.md."""


def grid_samples(light: Light, grid: int, weights: str, shift: tuple[float, float] = (0.0, 0.0)) -> Samples:
    """Points (n, 2) of a grid on the light in light space, and their weights (n,), small whole numbers.

    The outer points lie on the light's border, and with `weights` trapezoid count half, in the corners a quarter;
    midpoint puts points into the middle of grid×grid cells. A line has `grid` points; a light without size, one. They
    are moved by `shift` steps of the grid.
    """
    a, b = light.half_extent
    if weights != "midpoint" and grid > 1:
        steps = np.linspace(-1.0, 1.0, grid)
        ramp = np.ones(grid)
        if weights == "trapezoid":
            ramp[1:-1] = 2.0
    else:
        steps = (2.0 * np.arange(grid) + 1.0) / grid - 1.0
        ramp = np.ones(grid)
    if a == 0.0 and b == 0.0:
        return np.zeros((1, 2)), np.ones(1)
    spacing = float(steps[1] - steps[0]) if grid > 1 else 2.0
    x, y = (moved(steps, spacing, by) for by in shift)
    if b == 0.0 or a == 0.0:
        line = np.stack([x * a, x * b], axis=1)
        return line, ramp
    s, t = np.meshgrid((x + 1.0) / 2.0, (y + 1.0) / 2.0)
    offsets = light.points(s.ravel(), t.ravel()) - light.center
    return offsets @ light.axes[:2].T, np.outer(ramp, ramp).ravel()


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
        rays = self.visibility if isinstance(self.visibility, Rays) else Rays()

        def samples_of(light: Light, jitter: int) -> Samples:
            def points_at(shift: tuple[float, float]) -> np.ndarray:
                return grid_samples(light, self.grid, self.weights, shift)[0]

            weights = grid_samples(light, self.grid, self.weights)[1]
            return placed(points_at, jitter, rays.offsets), weights

        if not isinstance(self.visibility, Maps):
            return TracedPass(
                context,
                "techniques/uniform/trace.wgsl",
                samples_of=samples_of,
                resolution=self.resolution,
                uses_maps=isinstance(self.visibility, Hybrid),
                places=places_of(rays.offsets),
                noise=min(NOISE_COLUMNS / max(self.grid - 1, 1), 1.0) if rays.denoise else None,
            )
        return SampledPass(
            context,
            "techniques/uniform/uniform.wgsl",
            samples_of=samples_of,
            resolution=self.resolution,
            lookups=float,
            keeps_maps=True,
        )
