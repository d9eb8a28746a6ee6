"""How many samples' maps are held at one time, how large, and how many a submit may draw: all from sizes alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softshadows.errors import DeviceError
from softshadows.gpu.budget import SUBMIT_MS
from softshadows.gpu.device import Gpu
from softshadows.gpu.scene_buffers import SceneBuffers

AUTO_TILE_PER_IMAGE = 4.0
"""Edge of an automatic tile over the longer side of the image: the camera's pixels are rarely spread so unevenly over a
map that twice as many texels per axis are not enough for one texel per pixel."""
SMALLEST_AUTO_TILE, LARGEST_AUTO_TILE = 256, 4096


@dataclass(frozen=True)
class AtlasPlan:
    """Sizes the CPU knows beforehand. `tile` is the edge of a sample's tile, `atlas_size` the atlas's, in texels."""

    samples: int
    tile: int
    is_auto: bool
    tiles_per_row: int
    atlas_size: int
    samples_per_batch: int
    samples_per_chunk: int
    chunks: int

    @classmethod
    def of_tiles(
        cls,
        samples: int,
        tile: int,
        tiles_per_row: int,
        *,
        is_auto: bool,
        samples_per_batch: int | None = None,
        samples_per_chunk: int | None = None,
        chunks: int | None = None,
    ) -> AtlasPlan:
        """A square atlas of so many tiles; by default all samples are one batch and one chunk."""
        per_chunk = samples_per_chunk or samples
        return cls(
            samples=samples,
            tile=tile,
            is_auto=is_auto,
            tiles_per_row=tiles_per_row,
            atlas_size=tile * tiles_per_row,
            samples_per_batch=samples_per_batch or samples,
            samples_per_chunk=per_chunk,
            chunks=chunks or -(-samples // per_chunk),
        )

    @property
    def bytes(self) -> int:
        return 4 * self.atlas_size**2

    @property
    def holds_all(self) -> bool:
        """Do all samples' maps lie in the atlas at one time?"""
        return self.samples_per_batch >= self.samples and self.tiles_per_row**2 >= self.samples

    def starts_batch(self, chunk: int) -> bool:
        """Is the chunk the first of its batch?"""
        return chunk * self.samples_per_chunk % self.samples_per_batch == 0


def tile_size(gpu: Gpu, size: tuple[int, int], resolution: int | str, memory_budget: int) -> int:
    """Edge in texels of a map of `resolution` ("auto": by the image's size) that fits `memory_budget` MiB.

    Raises DeviceError where a map of that resolution exceeds the adapter's limit or the budget.
    """
    largest = gpu.limit("max-texture-dimension-2d")
    if resolution == "auto":
        wanted = 1 << int(np.ceil(np.log2(max(AUTO_TILE_PER_IMAGE * max(size), 1.0))))
        tile = int(np.clip(wanted, SMALLEST_AUTO_TILE, min(LARGEST_AUTO_TILE, largest)))
        while 4 * tile * tile > memory_budget * 2**20 and tile > SMALLEST_AUTO_TILE:
            tile //= 2
    else:
        tile = int(resolution)
    if tile > largest:
        raise DeviceError(
            f"a shadow map of {tile}² exceeds this adapter's largest texture ({largest}²). Lower the resolution."
        )
    if 4 * tile * tile > memory_budget * 2**20:
        raise DeviceError(
            f"a shadow map of {tile}² takes {4 * tile * tile / 2**20:.0f} MiB, more than the memory budget "
            f"of {memory_budget} MiB. "
            "Lower the resolution or raise the renderer's memory_budget."
        )
    return tile


def plan_atlas(
    gpu: Gpu,
    scene: SceneBuffers,
    size: tuple[int, int],
    samples: int,
    resolution: int | str,
    memory_budget: int,
    most_per_chunk: int | None = None,
) -> AtlasPlan:
    """How to hold `samples` maps of `resolution` within `memory_budget` MiB. Raises DeviceError as tile_size."""
    tile = tile_size(gpu, size, resolution, memory_budget)
    largest = gpu.limit("max-texture-dimension-2d")
    row_in_budget = int(np.sqrt(memory_budget * 2**20 / 4) // tile)
    per_row = max(min(largest // tile, row_in_budget, int(np.ceil(np.sqrt(samples)))), 1)
    milliseconds = scene.triangle_count / gpu.budget.triangles_per_ms + size[0] * size[1] / gpu.budget.lookups_per_ms
    # Rounded up: a chunk fills a submit, where one a little smaller would wait for a second one.
    most = min(per_row * per_row, samples, most_per_chunk or samples)
    per_chunk = int(np.clip(np.ceil(SUBMIT_MS / max(milliseconds, 1e-6)), 1, most))
    # A batch is whole chunks; but where the atlas holds all samples, all of them are one batch.
    per_batch = samples if per_row * per_row >= samples else per_row * per_row // per_chunk * per_chunk
    return AtlasPlan.of_tiles(
        samples,
        tile,
        per_row,
        is_auto=resolution == "auto",
        samples_per_batch=per_batch,
        samples_per_chunk=per_chunk,
    )
