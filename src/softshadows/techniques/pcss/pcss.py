"""Percentage-closer soft shadows: penumbra width from the mean distance of blockers, in one shadow map.

Paper
    [Fernando2005]  Fernando, "Percentage-Closer Soft Shadows", SIGGRAPH 2005 sketches.

Section map
    [Fernando2005 §blocker search]       mean distance of nearer texels    -> pcss.wgsl mean_blocker_share()
    [Fernando2005 §penumbra estimation]  w (d_rec. - d_bl.) / d_bl.        -> light_filter.wgsl penumbra_half_extent()
    [Fernando2005 §filtering]            PCF as wide as the penumbra       -> light_filter.wgsl filter_shadow()

Departures from the paper
    - Search and filter regions have the light's own shape and orientation, in metres, instead of a square in the map:
      rectangles filter with rectangles, lines along the line.
    - The near plane of the blocker search is the nearest occluder in the map, found on the GPU, instead of a chosen
      one.
    - Taps compare with the receiver's plane; the paper leaves bias open.

Use when
    one shadow map must do, occluders are simple, and contact hardening matters more than correctness.
Fails when
    occluders at different heights overlap, for the mean mixes them (scene `sphere_cube`: light in most of the umbra);
    when the light's centre does not see what its border sees (scene `fence`). A near occluder anywhere in the map
    widens every search.
Inputs
    rectangle, disk and line lights.
Cost
    one shadow map, blocker_samples + filter_samples look-ups per pixel near shadows, blocker_samples elsewhere.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.gpu.commands import Commands
from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques.base import Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import resolution_option
from softshadows.techniques.light_pass import ChunkPrograms, Combination, LightPass, map_source
from softshadows.techniques.options import option
from softshadows.techniques.taps import sequence, taps, upload_taps
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps

SEARCH_MARGIN = 1.0
"""Half lights by which the map reaches beyond the receivers in view: enough for blockers at half their distance."""


class Pcss(Technique):
    """Percentage-closer soft shadows: a search for blockers sets how wide each shadow edge is filtered.

    The presets are the usual numbers of taps of the two.
    """

    name: ClassVar[str] = "pcss"
    light_kinds: ClassVar[frozenset[str]] = frozenset({"rect", "disk", "line"})
    presets: ClassVar[Presets] = {
        "64/64": {},
        "32/64": {"blocker_samples": 32},
        "16/24": {"blocker_samples": 16, "filter_samples": 24},
    }

    blocker_samples: int = option(default=64, help="taps of the blocker search", low=1, high=1024)
    filter_samples: int = option(default=64, help="taps of the filter", low=1, high=1024)
    resolution: int | str = resolution_option(1024)

    def build(self, context: RenderContext) -> TechniquePass:
        maps = map_source(context, self.resolution, MapOptions(search_margin=SEARCH_MARGIN))
        return LightPass(context, Sampling(center_sample), maps, _SearchedAndFiltered(context, self))


class _SearchedAndFiltered(Combination[ShadowMaps]):
    """A search for blockers, and a filter as wide as the penumbra behind them."""

    def __init__(self, context: RenderContext, technique: Pcss) -> None:
        super().__init__(context)
        blocker_taps, filter_taps = technique.blocker_samples, technique.filter_samples
        self._lookups = float(blocker_taps + filter_taps)
        self._nearest = context.gpu.storage_buffer(16, "the nearest occluder")
        self._taps = upload_taps(context.gpu, sequence(blocker_taps), taps("grid", filter_taps))
        self._programs = ChunkPrograms(
            context,
            "techniques/pcss/pcss.wgsl",
            "cs_nearest",
            "cs_visibility",
            resources={"taps": self._taps, "nearest_bits": self._nearest},
            constants={"blocker_taps": blocker_taps, "filter_taps": filter_taps},
        )

    @property
    def bytes(self) -> int:
        return self._taps.size + self._nearest.size

    def lookups(self, samples: int) -> float:
        return self._lookups

    def encode(self, commands: Commands, provider: ShadowMaps, chunk: int) -> None:
        commands.encoder.clear_buffer(self._nearest)
        groups = -(-provider.plan.atlas_size // 8)
        run = self._programs.encode
        run(commands, "nearest_occluder", "cs_nearest", provider, chunk, groups=(groups, groups))
        run(commands, "lookup", "cs_visibility", provider, chunk)
