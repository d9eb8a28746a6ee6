"""Rectified shadow maps from points of a line light: an image row is a plane through the light, the same in all maps.

    ../maps/           boxes around the receivers, places in the atlas, the draw
    line_space.wgsl    the faces: four around the light, in tangents u along it and v around it, and two caps
    fit.wgsl           windows that all samples share, and which maps are drawn
    line_map.wgsl      look-ups

What a technique may rely on, for samples i = 0 … n − 1 evenly spaced from the light's start (i = 0) to its end:

    - A face's view has the same size and texels per unit in every sample, and with two samples the same window along v:
      row j of one is the same plane through the light as row j of the other. With more, each sample's rows lie a part
      of a row further on than those of the one before, a row in all; row j of neighbours is the same plane to within
      half a row. `window_low.x` differs: `column_position(view, column)` gives a column's u, and a point of inverse
      depth c moves by `disparity(from_x, to_x, c)` from map to map. u runs from start to end of the light on all faces.
    - The atlas holds near × inverse depth, which is 1 / d with d the distance from the light's line along the face's
      axis: the same in all maps, affine in the image on every plane, 0 where there is nothing.
    - `line_map_sample(sample, receiver)` projects a receiver into a sample's map (shadow_map.wgsl): `.view`, its texel
      by `covering_texel(map_sample)`, and `map_sample_is_lit(map_sample)`, the hard test. Where
      `is_rectified(map_sample)` is false the receiver lies in a cap (more than 76° from the light's normal) or outside
      all maps: only the hard test holds there.
    - The windows hold only what some occluder takes of a map, seen from anywhere on the light: what lies outside is lit
      from all samples.
    - `reach` half lights of room along u, beside the receivers in view, for occluders' edges just out of the picture.

Per light: `encode_receivers`, `encode_fit`, then `encode_maps(stage)`. Which samples a stage draws is a word of bits in
`requests`, which `write` fills with all samples in the first stage; a technique may write it on the GPU before its
stage. All maps are cached, and none drawn, while they still show what the camera sees; `state` tells which samples were
drawn in this frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softshadows.errors import DeviceError
from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import F32, U32, Struct, Vec2f, dtype
from softshadows.gpu.program import Program, Resource
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.lights.sample_sets import SampledLight
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.lights import Light
from softshadows.visibility.maps.plan import AtlasPlan, tile_size
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps
from softshadows.visibility.maps.structs import FACES

COLUMNS = constant("visibility/line_maps/line_map.wgsl", "COLUMNS")
"""The most in which a tile's faces lie side by side (fit.wgsl)."""
TEXELS_PER_PIXEL = 4.0
"""Texels of an automatic map along a pixel: few maps may be finer than many.

Measured: docs/decisions/0013-line-shadow-maps.md.
"""
MOST_SAMPLES = 32
"""A set of samples is a word of bits."""


class LineWindow(Struct):
    """A face's window in all maps: low corner seen from the light's start, how far it drifts along u to the end's."""

    low_first: Vec2f
    extent: Vec2f  # negative: not in use
    drift: F32
    texels_per_unit: F32


class LineState(Struct):
    """Which samples' maps were drawn in this frame, as bits; 0 where all were kept. How the faces share a tile."""

    drawn_now: U32
    columns: U32


class Stage(Struct):
    """Which of the frame's draws this is."""

    number: U32


def plan_line_maps(
    gpu: Gpu,
    size: tuple[int, int],
    samples: int,
    resolution: int | str,
    memory_budget: int,
    *,
    stages: int = 1,
    bytes_per_texel: int = 4,
) -> AtlasPlan:
    """An atlas that holds all `samples` maps within `memory_budget` MiB, drawn in `stages`.

    `bytes_per_texel` counts what a technique keeps beside the maps, too. Raises DeviceError where it does not fit.
    """
    tile = tile_size(gpu, size, resolution, memory_budget)
    per_row = int(np.ceil(np.sqrt(samples)))
    largest = min(int(np.sqrt(memory_budget * 2**20 / bytes_per_texel)), gpu.limit("max-texture-dimension-2d"))
    if resolution == "auto":
        tile = min(tile, largest // per_row)
    if tile * per_row > largest or tile < 1:
        raise DeviceError(
            f"{samples} rectified shadow maps of {tile}² are needed at one time, more than the memory budget of "
            f"{memory_budget} MiB or this adapter's largest texture holds. Lower the resolution or the number of "
            "samples, or raise the renderer's memory_budget."
        )
    return AtlasPlan.of_tiles(samples, tile, per_row, is_auto=resolution == "auto", chunks=stages)


def line_points(light: Light, samples: int) -> np.ndarray:
    """(samples, 2) float64: points from the light's start to its end, in light space."""
    points = np.zeros((samples, 2))
    points[:, 0] = np.linspace(-1.0, 1.0, samples) * light.half_extent[0] if samples > 1 else 0.0
    return points


class LineMaps:
    """The maps of line lights with `plan.samples` samples each, one light at a time. See the module."""

    def __init__(
        self,
        gpu: Gpu,
        scene: SceneBuffers,
        gbuffer: GBuffer,
        plan: AtlasPlan,
        *,
        reach: float = 1.0,
    ) -> None:
        assert plan.samples <= MOST_SAMPLES
        self.plan, self._gpu = plan, gpu
        options = MapOptions(search_margin=reach, texels_per_pixel=TEXELS_PER_PIXEL, caches=True)
        self.atlas = atlas = ShadowMaps(gpu, scene, gbuffer, plan, options)
        self._triangle_ms = scene.triangle_count / gpu.budget.triangles_per_ms
        self._windows = gpu.storage_buffer(FACES * dtype(LineWindow).itemsize, "the windows")
        self.state = gpu.storage_buffer(dtype(LineState).itemsize, "the state of the maps")
        self.requests = gpu.storage_buffer(4 * plan.chunks, "the requested samples")
        self.bytes = atlas.bytes + self._windows.size + self.state.size + self.requests.size
        resources: dict[str, Resource] = {
            **atlas.fit_resources,
            "line_windows": self._windows,
            "state": self.state,
            "requests": self.requests,
            "occluder_boxes": scene.occluder_boxes,
        }
        self._fit, self._place = (
            Program(gpu, "visibility/line_maps/fit.wgsl", entry, resources) for entry in ("cs_fit", "cs_place")
        )
        self._stages = [self._place.bind(stage=gpu.uniform(Stage(number=stage))) for stage in range(plan.chunks)]

    @property
    def resources(self) -> dict[str, Resource]:
        """What line_map.wgsl declares."""
        return self.atlas.resources

    def write(
        self,
        lights: Sequence[tuple[Light, int]],
        first_stage: int | None = None,
        *,
        keeps_looser_fits: bool = False,
    ) -> None:
        """Write the frame's lights, each with its layer of visibility, and the first stage's samples (default: all).

        With `keeps_looser_fits` maps may serve that new ones would fit more tightly.
        """
        samples, weights = self.plan.samples, np.ones(self.plan.samples)
        self.atlas.write(
            [SampledLight(light, layer, line_points(light, samples), weights) for light, layer in lights],
            keeps_looser_fits=keeps_looser_fits,
        )
        words = np.zeros(self.plan.chunks, np.uint32)
        words[0] = (1 << samples) - 1 if first_stage is None else first_stage
        self._gpu.write(self.requests, 0, words, what="constant")

    def encode_receivers(self, commands: Commands, index: int) -> None:
        """Select light `index`: find boxes around what the camera sees and something can shadow."""
        self.atlas.encode_receivers(commands, index)

    def encode_fit(self, commands: Commands) -> None:
        """Fit the windows to the receivers, or find that those of the last frame still serve."""
        with commands.compute("fit") as compute:
            self._fit.dispatch(compute, (1,))

    def encode_maps(self, commands: Commands, stage: int = 0, *, at_most: int | None = None) -> None:
        """Draw the maps that the stage requests, `at_most` so many, where the atlas does not hold them."""
        with commands.compute("fit") as compute:
            self._place.dispatch(compute, (1,), self._stages[stage])
        self.atlas.encode_draw(commands, stage)
        commands.account((at_most or self.plan.samples) * self._triangle_ms)
