"""Where a filter looks: patterns of points in the square [-1, 1]², made once and uploaded."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.gpu.device import Gpu

PATTERNS = ("grid", "poisson")
_CANDIDATES = 64
_SEED = 2005


def taps(pattern: str, count: int) -> npt.NDArray[np.float32]:
    """(count, 2) float32: a "grid" of cell centres that fills the square, or a "poisson" disk of radius 1.

    The Poisson disk is a best-candidate set (Mitchell 1991) from a fixed seed, so that it is the same in every run.
    """
    return _grid(count) if pattern == "grid" else _poisson_disk(count)


def sequence(count: int) -> npt.NDArray[np.float32]:
    """(count, 2) float32: a sequence whose every part fills the square evenly (Roberts 2018, "R2")."""
    plastic = 1.32471795724474602596
    steps = np.arange(1, count + 1)[:, None] * np.array([1.0 / plastic, 1.0 / plastic**2])
    return (2.0 * ((0.5 + steps) % 1.0) - 1.0).astype(np.float32)


def upload_taps(gpu: Gpu, *patterns: npt.NDArray[np.float32]) -> wgpu.GPUBuffer:
    """One array<vec2f> with the patterns behind one another."""
    data = np.concatenate(patterns).astype(np.float32)
    buffer = gpu.storage_buffer(data.nbytes, "the taps")
    gpu.write(buffer, 0, data, what="constant")
    return buffer


def _grid(count: int) -> npt.NDArray[np.float32]:
    rows = max(divisor for divisor in range(1, int(np.sqrt(count)) + 1) if count % divisor == 0)
    columns = count // rows
    x = (2.0 * np.arange(columns) + 1.0) / columns - 1.0
    y = (2.0 * np.arange(rows) + 1.0) / rows - 1.0
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(np.float32)


def _poisson_disk(count: int) -> npt.NDArray[np.float32]:
    random = np.random.default_rng(_SEED)
    points = np.zeros((1, 2))
    while len(points) < count:
        radius, angle = np.sqrt(random.random(_CANDIDATES)), 2.0 * np.pi * random.random(_CANDIDATES)
        candidates = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        distance = np.linalg.norm(candidates[:, None] - points[None], axis=2).min(axis=1)
        points = np.vstack([points, candidates[distance.argmax()]])
    return points[:count].astype(np.float32)
