"""Adaptive light sampling: hard shadow maps from as few points of the light as the picture needs, averaged.

Paper
    [Schwaerzler2012]  Schwärzler, Mattausch, Scherzer, Wimmer, "Fast Accurate Soft Shadows with Adaptive Light Source
    Sampling", VMV 2012.

Section map
    [Schwaerzler2012 §3.3.3]  four maps compared in the picture   -> compare.wgsl visible_corners() failing_cells()
    [Schwaerzler2012 §3.3.4]  subdivision of the light            -> refine.wgsl request_children()
    [Schwaerzler2012 Eq. 3]   weights of the samples              -> weights.wgsl paper_weight()
    [Schwaerzler2012 §3.4.3]  a small filter on every map         -> filter.wgsl filtered_by_pcf()

Departures from the paper
    - `refinement="tile"` is the default: every tile of 8×8 pixels refines the light for itself. One wide penumbra
      anywhere makes the paper's single tree (`refinement="global"`) refine the light for the whole picture. A tile
      starts with nine samples, since four alone overlook what hides the light's middle, and refines the next two levels
      wherever it or the tile beside it sees a part of a cell. From there on the paper's test decides. Measured:
      docs/decisions/0010-adaptive.md.
    - `weights="area"` is the default: a cell gives a quarter of its area to each corner, the trapezoid rule.
      `weights="paper"` is equation 3; for a sample between cells of different depth, which the paper leaves open, the
      deepest one counts.
    - No occlusion queries and no read-back: all levels are encoded at once, and the GPU decides what they draw. That
      also replaces the paper's reuse of the last frame's subdivision; what is reused are the maps, where all fit the
      atlas.
    - Each map is looked up once per pixel and stored as a bit, so that comparison and average share the look-ups.
      The bits are added up in one pass; the paper's sums map by map are the same.
    - A tile that nothing can shadow asks for no maps. Background does not count in the 1-ring.
    - Shadow maps are fitted to the tiles that request them (docs/decisions/0001-shadow-maps.md), deep levels' more
      coarsely; where a level's maps exceed the memory budget they shrink, or are drawn one batch after the other.
    - `filter="cell"` is an addition: a sample beside a silhouette stands for the part of the light around it. Nine taps
      in its map, spread by the occluder's distance, turn the band between two samples into a ramp.
    - `visibility="ray"` traces rays instead of maps: no texel, no bias, nothing to fit or cache. Since a tile's pixels
      then may look at other points, each sends four *probes*, which together reach every cell of the light and show
      what hides between the tile's samples; samples are sheared, so that an edge along a side of the light does not
      meet a row of them at once; and on a line four more rays find each edge between two samples. `visibility="hybrid"`
      asks a ray only where the four texels around a look-up do not agree. Measured: docs/decisions/0017-rays.md.
    - With rays, `visibility.offsets=stratified` asks about other points in each of 4×4 pixels, and `visibility.denoise`
      averages what lies on one surface and differs by no more than a row of the deepest cells; changes across the
      window stay. With both, `max_depth=3` errs about as little as the default or less on rectangles, for 0.56 to 0.86
      of its rays; on lines offsets add noise.
    - `Renderer.refine` averages frames whose samples lie at other places beside the lattice's points, for a picture
      that converges while nothing moves.

Use when
    you want the soft shadow of `uniform` for a fraction of its cost. `filter="cell"` with `max_depth=2` (25 maps) for
    simple occluders, when speed matters more. `visibility="ray"` when the shadow must be right: thin occluders,
    contacts, large scenes; it also is faster than many maps that have to be drawn again.
Fails when
    the penumbra is wider on screen than twice 2^max_depth pixels: bands show, and `frame.stats.warnings` says so
    (scene `blocker`, seen from near). Occluders that hide none of a cell's corners in a whole tile go unseen
    (scene `fence` with `max_depth=1`). `filter="cell"` errs where several silhouettes at different distances cross
    (scene `atrium`). `visibility="hybrid"` misses what its maps' texels miss (shot `bike_near` at 512²). Where a band
    is as wide as the test allows, a small change can refine a whole tile.
Inputs
    rectangle and line lights.
Cost
    up to 289 shadow maps (17 on a line), as many look-ups per pixel as its tile's tree has samples, and 40 bytes of
    memory per pixel, with "hybrid" 80. Two more passes a level decide; no more than a tenth of the frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.lights.lattice import DEEPEST, Lattice, lattice_of
from softshadows.scene.lights import Light
from softshadows.techniques.adaptive.plan import plan_batches
from softshadows.techniques.adaptive.sampling import REPORT_WORDS, AdaptiveSampling, SamplingOptions
from softshadows.techniques.adaptive.tree_buffers import TILE
from softshadows.techniques.base import Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.common_options import (
    VISIBILITIES,
    VISIBILITY_HELP,
    Hybrid,
    Maps,
    Rays,
    check_resolution,
    resolution_option,
)
from softshadows.techniques.options import Choice, choice, one_of, option
from softshadows.techniques.workers import Workers, lights_of
from softshadows.visibility.denoise.denoise import Denoise
from softshadows.visibility.rays.tree import CUT_SHORT, tree_of


class NoFilter(Choice):
    """A sample is a point: visible or not."""

    name: ClassVar[str] = "none"


class CellFilter(Choice):
    """A sample is the part of the light around it: ramps in place of bands."""

    name: ClassVar[str] = "cell"


class PcfFilter(Choice):
    """Every map is looked up in several texels: the paper's filter against banding."""

    name: ClassVar[str] = "pcf"

    texels: int = option(default=3, help="texels along the filter's side", choices=(2, 3))


class Adaptive(Technique):
    """Shadow maps from points of the light, as dense as each part of the picture needs. The module is its manual."""

    name: ClassVar[str] = "adaptive"
    light_kinds: ClassVar[frozenset[str]] = frozenset({"rect", "line"})
    refines: ClassVar[bool] = True
    presets: ClassVar[Presets] = {"paper": {"refinement": "global", "weights": "paper", "resolution": 512}}

    max_depth: int = option(default=4, help="how often the light may be halved; 4 gives 289 maps", low=0, high=DEEPEST)
    refinement: str = option(
        default="tile",
        help="one tree for each tile of 8×8 pixels, or the paper's global one",
        choices=("tile", "global"),
    )
    weights: str = option(default="area", help="how samples are weighted", choices=("area", "paper"))
    comparison_scale: float = option(
        default=1.0, help="size of the comparison over the picture's", choices=(1.0, 0.5, 0.25)
    )
    threshold: int = option(
        default=0, help="texels of the comparison that may fail before a cell is refined", low=0, high=1 << 24
    )
    visibility: Maps | Rays | Hybrid = choice(default=Maps(), converter=VISIBILITIES, help=VISIBILITY_HELP)
    filter: NoFilter | CellFilter | PcfFilter = choice(
        default=NoFilter(),
        converter=one_of(NoFilter, CellFilter, PcfFilter),
        help="take a sample as a point, as the part of the light around it, or averaged over texels of its map",
    )
    resolution: int | str = resolution_option("auto")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.filter, NoFilter) and not isinstance(self.visibility, Maps):
            raise OptionError(
                f"adaptive: filter={self.filter.name} looks into shadow maps, and visibility={self.visibility.name} "
                "traces rays. Use visibility=map, or no filter."
            )
        check_resolution(self.name, self.visibility, self.resolution)

    def build(self, context: RenderContext) -> TechniquePass:
        return AdaptivePass(context, self)


class AdaptivePass(TechniquePass):
    """The technique at work: one AdaptiveSampling for every shape of light in the scene."""

    def __init__(self, context: RenderContext, technique: Adaptive) -> None:
        super().__init__()
        self._context, self._technique = context, technique
        self._report = context.gpu.storage_buffer(4 * REPORT_WORDS, "the report")
        self._samplings: Workers[Lattice, AdaptiveSampling] = Workers(self._new_sampling, context.memory_budget)
        self._by_light: list[tuple[AdaptiveSampling, int]] = []  # per light: who samples it, and its index there
        self._rays = technique.visibility if isinstance(technique.visibility, Rays) else Rays()
        self._denoise = None
        if self._rays.denoise:
            noise = 1.0 / (1 << technique.max_depth)  # a row of the lattice's cells
            self._denoise = Denoise(context.gpu, context.gbuffer, context.visibility, noise)

    def write(self, lights: Mapping[int, Light]) -> None:
        if self._denoise is not None:
            self._denoise.write([*lights])
        depth = self._technique.max_depth
        by_light = self._samplings.assign({layer: lattice_of(light, depth) for layer, light in lights.items()})
        for sampling, layers in lights_of(by_light).items():
            own = [(lights[layer], layer) for layer in layers]
            sampling.write(own, self.refinements, keeps_looser_fits=self.keeps_looser_fits)
        self._by_light = [*by_light.values()]
        self.bytes = self._samplings.bytes
        if not isinstance(self._technique.visibility, Maps):
            self.bytes += tree_of(self._context.scene).bytes
        self.bytes += self._denoise.bytes if self._denoise is not None else 0

    def _new_sampling(self, lattice: Lattice) -> AdaptiveSampling:
        context, technique = self._context, self._technique
        size = context.gbuffer.size
        options = SamplingOptions(
            is_global=technique.refinement == "global",
            threshold=technique.threshold,
            comparison_step=round(1.0 / technique.comparison_scale),
            paper_weights=technique.weights == "paper",
            pcf=technique.filter.texels if isinstance(technique.filter, PcfFilter) else 0,
            filters_cells=isinstance(technique.filter, CellFilter),
            visibility=technique.visibility.name,
            offsets=self._rays.offsets,
        )
        if isinstance(technique.visibility, Rays):
            plan, batches = None, [1] * (lattice.depth + 1)
        else:
            plan, batches = plan_batches(
                context.gpu,
                lattice,
                size,
                technique.resolution,
                context.memory_budget,
                holds_all=options.is_filtered,
            )
        return AdaptiveSampling(context, lattice, plan, batches, options, self._report)

    def encode(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._report)
        for sampling, index in self._by_light:
            sampling.encode(commands, index)
        if self._denoise is not None:
            self._denoise.encode(commands)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"report": (self._report, "<u4", (REPORT_WORDS,))}

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        maps, capped, low, high, cut_short = (int(word) for word in results["report"])
        width, height = self._context.gbuffer.size
        self.shadow_maps = 0 if isinstance(self._technique.visibility, Rays) else maps
        self.lookups_per_pixel = (low + (high << 32)) / (width * height)
        self.warnings = []
        if cut_short:
            self.warnings.append(CUT_SHORT)
        if capped:
            self.warnings.append(
                f"adaptive: max_depth={self._technique.max_depth} leaves bands in {capped} of "
                f"{-(-width // TILE) * -(-height // TILE)} tiles of {TILE}×{TILE} pixels"
            )
