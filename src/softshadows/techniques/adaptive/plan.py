"""How a level's maps are cut into draws, by sizes that the CPU knows beforehand."""

from __future__ import annotations

import numpy as np

from softshadows.errors import DeviceError
from softshadows.gpu.device import Gpu
from softshadows.lights.lattice import Lattice
from softshadows.visibility.maps.plan import AtlasPlan, tile_size

BATCHES = (1, 2, 4, 8, 16)
"""By level: the most draws that its maps are cut into where they do not fit the atlas at full size."""


def plan_batches(
    gpu: Gpu,
    lattice: Lattice,
    size: tuple[int, int],
    resolution: int | str,
    memory_budget: int,
    *,
    holds_all: bool,
) -> tuple[AtlasPlan, list[int]]:
    """The atlas, and by level the number of draws that its maps are cut into. Raises DeviceError as tile_size.

    `holds_all`: all maps are needed at one time, so they are made small enough for it.
    """
    samples, counts = lattice.rows * lattice.columns, [lattice.count(level) for level in range(lattice.depth + 1)]
    tile = tile_size(gpu, size, resolution, memory_budget)
    atlas_size = min(int(np.sqrt(memory_budget * 2**20 / 4)), gpu.limit("max-texture-dimension-2d"))
    per_row = int(np.ceil(np.sqrt(samples)))
    if holds_all and resolution == "auto":
        tile = min(tile, atlas_size // per_row)
    atlas_size = min(atlas_size, tile * per_row)
    if holds_all and tile * per_row > atlas_size:
        raise DeviceError(
            f"filtered adaptive sampling holds {samples} shadow maps of {tile}² at one time, more than the memory "
            f"budget of {memory_budget} MiB. Lower max_depth or the resolution, or raise the renderer's memory_budget."
        )
    at_one_time = (atlas_size // tile) ** 2
    batches = [-(-count // at_one_time) for count in counts]
    if resolution == "auto":  # smaller maps rather than many draws
        batches = [min(wanted, most) for wanted, most in zip(batches, BATCHES, strict=False)]
    plan = AtlasPlan(
        samples=samples,
        tile=tile,
        is_auto=resolution == "auto",
        tiles_per_row=atlas_size // tile,
        atlas_size=atlas_size,
        samples_per_batch=samples,
        samples_per_chunk=max(-(-count // draws) for count, draws in zip(counts, batches, strict=True)),
        chunks=sum(batches),
    )
    return plan, batches
