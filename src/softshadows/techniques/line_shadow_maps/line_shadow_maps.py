"""Soft shadow maps for linear lights: few maps, and in each the share of the light that what it shows can see.

Paper
    [Heidrich2000]  Heidrich, Brabec, Seidel, "Soft Shadow Maps for Linear Lights", Eurographics Workshop on Rendering
    2000.

Section map
    [Heidrich2000 §3]      shade(): hard tests weighed by visibility channels  -> visibility.wgsl cs_visibility()
    [Heidrich2000 §3]      and by the samples' illumination, `shading="ends"`  -> visibility.wgsl segment_shares()
    [Heidrich2000 §3.2]    skins across depth discontinuities                  -> skins.wgsl cs_find() add_skin()
    [Heidrich2000 §3.2]    skins warped into the other map                     -> channels.wgsl vs_skin() fs_skin()
    [Heidrich2000 Eq. 1]   the exact transition across a penumbra              -> channels.wgsl rational_share()
    [Heidrich2000 §3.3]    more samples, a light for every two neighbours      -> visibility.wgsl cs_visibility()
    [Heidrich2000 §4]      3×3 Laplacian of Gaussian                           -> skins.wgsl laplacian()

Departures from the paper
    The preset `paper` undoes the first four. Measured: docs/decisions/0013-line-shadow-maps.md.
    - `samples="auto"` (paper: two) draws both ends and the middle of the light, and inserts samples where what the
      middle one sees contradicts its neighbours, up to nine.
    - A point that both ends see takes the sum of its channels. The paper's text assumes that it sees all of the light
      (`between="ends"`), and so misses what hides only the middle; its own skins know better (O9 0.5 -> 0.003).
    - `between="rows"`: a row of two neighbouring maps shows every gap between occluders that one of them sees, so that
      light which neither end sees is found there (O10 0.5 -> 0.005), in 32 parts of the segment.
    - `transition="rational"` evaluates equation 1 with the depth of the surface in every texel. The linear ramp is
      linear in the map: where floor and light are not parallel it deviates by (√r − 1)/(√r + 1), r the ratio of
      (occluder's − floor's reciprocal depth) at the penumbra's ends.
    - With more than two samples, each one's rows lie a part of a row further on: an edge along the light, a step that
      all maps would put on one row, keeps its place (classroom_tube 0.051 -> 0.040).
    - Maps hold reciprocal depth, of which the Laplacian vanishes on planes at any slope. A discontinuity is where it
      changes sign over a jump of at least a texel of the occluder's distance; the paper gives no threshold.
    - Of overlapping skins the least share counts; skins are drawn only into the map that looks behind their edge. In
      the other they would be hidden behind the occluder.
    - Visibility is the sum of the channels, without the illumination at each end: lighting multiplies it with
      the unshadowed radiance of the whole line. `shading="ends"` weighs the channels as the paper does, over the same
      sum for the whole light, and no brighter than that: an end that alone sees a point stands for all that is seen.

Use when
    the light is a line, and its soft shadow has to come from few maps.
Fails when
    what hides a part of the light shows in neither neighbouring map (deep stacks such as `sphere_cube` with two
    samples); where an occluder is so near the light that its edge lies more than 76° off in the map, or the light runs
    into something, to within half a segment (shot classroom_tube); where thin things fall between texels (scene
    `atrium`). The paper's version misses strips and slits between its samples (scene `fence`).
Inputs
    line lights; for a triangular light its three sides, as in the paper (`LineLight.outline`).
Cost
    3 to 9 shadow maps, 8 bytes per texel of all that there may be; 4 MiB of skins or more; a look-up per pixel
    and map, and in penumbrae a walk along the rows. Two samples of the paper's take 1.03 to 1.2 of the time of two hard
    shadows, and 1.05 with the maps cached.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.scene.lights import Light
from softshadows.techniques.base import Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import SHADING_HELP, resolution_option
from softshadows.techniques.line_shadow_maps.soft_maps import REPORT_WORDS, SoftMapOptions, SoftMaps
from softshadows.techniques.options import Choice, choice, option, whole_number_or
from softshadows.techniques.workers import Workers, lights_of

MOST_SAMPLES = 9
"""As many as `samples="auto"` takes."""


class AutoSamples(Choice):
    """Both ends and the middle of the light, and more where what the maps show contradicts itself."""

    name: ClassVar[str] = "auto"


class LineShadowMaps(Technique):
    """Soft shadows of line lights from shadow maps with visibility channels. The module's text is its manual.

    The preset `paper` is the paper's: two samples, maps of 500 texels, linear transitions.
    """

    name: ClassVar[str] = "line_shadow_maps"
    light_kinds: ClassVar[frozenset[str]] = frozenset({"line"})
    presets: ClassVar[Presets] = {
        "paper": {"samples": 2, "resolution": 500, "transition": "linear", "between": "ends"},
    }

    samples: int | AutoSamples = choice(
        default=AutoSamples(),
        converter=whole_number_or(AutoSamples, low=2, high=17),
        help="points on the light, evenly spaced; auto inserts them where the maps contradict each other",
    )
    transition: str = option(
        default="rational",
        help="of visibility across a penumbra: the paper's linear one, or exact for the surface in each texel",
        choices=("rational", "linear"),
    )
    between: str = option(
        default="rows",
        help="what is known of a segment between its ends: what the channels and the maps' rows show, the channels "
        "alone, or nothing: who sees both ends sees all of it, as the paper assumes",
        choices=("rows", "channels", "ends"),
    )
    shading: str = option(default="whole", help=SHADING_HELP, choices=("whole", "ends"))
    resolution: int | str = resolution_option("auto")

    def build(self, context: RenderContext) -> TechniquePass:
        return LineShadowMapsPass(context, self)


class LineShadowMapsPass(TechniquePass):
    """One SoftMaps for lights with a length, one with a single map for those without."""

    def __init__(self, context: RenderContext, technique: LineShadowMaps) -> None:
        super().__init__()
        self._context, self._technique = context, technique
        self._report = context.gpu.storage_buffer(4 * REPORT_WORDS, "the report")
        # By whether the light has a length.
        self._soft_maps: Workers[bool, SoftMaps] = Workers(self._new_maps, context.memory_budget)
        self.by_light: list[tuple[SoftMaps, int]] = []  # per light: its maps, and its index there

    def write(self, lights: Mapping[int, Light]) -> None:
        by_light = self._soft_maps.assign({layer: light.has_size for layer, light in lights.items()})
        for maps, layers in lights_of(by_light).items():
            maps.write([(lights[layer], layer) for layer in layers], keeps_looser_fits=self.keeps_looser_fits)
        self.by_light = [*by_light.values()]
        self.bytes = self._soft_maps.bytes

    def _new_maps(self, has_length: bool) -> SoftMaps:
        technique, samples = self._technique, self._technique.samples
        is_auto = has_length and isinstance(samples, AutoSamples)
        count = MOST_SAMPLES if isinstance(samples, AutoSamples) else samples
        options = SoftMapOptions(
            samples=count if has_length else 1,
            is_auto=is_auto,
            is_rational=technique.transition == "rational",
            both_ends_see_all=technique.between == "ends",
            looks_for_gaps=technique.between == "rows",
            by_ends=technique.shading == "ends",
            resolution=technique.resolution,
        )
        return SoftMaps(self._context, options, self._report)

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._report)
        for maps, index in self.by_light:
            maps.encode(commands, index)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"report": (self._report, "<u4", (REPORT_WORDS,))}

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        self.clamped, self.shadow_maps, self.skins, dropped = (int(word) for word in results["report"])
        self.lookups_per_pixel = float(self.shadow_maps)
        self.warnings = []
        if dropped:
            self.warnings.append(
                f"line_shadow_maps: {dropped} of {self.skins} skins were left out. Lower the resolution."
            )
