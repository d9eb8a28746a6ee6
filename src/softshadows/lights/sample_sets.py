"""Where a light is sampled: points that stand for it, and the light with its points on the GPU."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import wgpu

from softshadows.gpu.device import Gpu
from softshadows.gpu.layout import dtype, pack
from softshadows.gpu.program import Resource, Slice
from softshadows.gpu.selection import Selection
from softshadows.lights import record
from softshadows.scene.lights import Light

UNIFORM_ALIGNMENT = 256
"""WebGPU: of a uniform's offset in its buffer."""

Samples = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
"""points (places × n, 2) in light space, metres, and weights (n,). A sample has one place, or several by pixel
(jitter.py)."""


@dataclass(frozen=True)
class Sampling:
    """Where a technique samples lights. `points` takes a light and the number of a shift of its points (jitter.py).

    A technique of the light's centre alone `ignores_size`: it is told of a light without one.
    """

    points: Callable[[Light, int], Samples]
    ignores_size: bool = False


def center_sample(light: Light, jitter: int = 0) -> Samples:
    """The light's centre alone, whatever the jitter."""
    return np.zeros((1, 2)), np.ones(1)


@dataclass(frozen=True, eq=False)
class SampledLight:
    """A light, its layer of visibility, its samples: points (places × n, 2), metres of light space; weights (n,)."""

    light: Light
    layer: int
    points: npt.NDArray[np.float64]
    weights: npt.NDArray[np.float64]


class SampleSet:
    """Lights with `count` samples each, one light at a time, and the chunks of samples that one dispatch takes.

    `resources` and `chunk` are what light_samples.wgsl declares.
    """

    def __init__(self, gpu: Gpu, count: int, *, places: int = 1, per_chunk: int | None = None) -> None:
        self.count, self.per_chunk = count, per_chunk or count
        self.chunks = -(-count // self.per_chunk)
        self.light = gpu.storage_buffer(dtype(record.Light).itemsize, "a light")
        size = dtype(record.LightSamples).itemsize + 16 * places * count
        self.points = gpu.storage_buffer(size, "a light's samples")
        self._selection = Selection(gpu, [(self.light, 0), (self.points, 0)])
        self._chunks = gpu.buffer(UNIFORM_ALIGNMENT * self.chunks, wgpu.BufferUsage.UNIFORM, "the chunks of samples")
        gpu.write(self._chunks, 0, self._chunk_records(), what="constant")

    @property
    def bytes(self) -> int:
        return self.light.size + self.points.size + self._selection.bytes + self._chunks.size

    @property
    def resources(self) -> dict[str, Resource]:
        """The light whose turn it is, and its samples."""
        return {"light": self.light, "light_samples": self.points}

    def chunk(self, number: int) -> Slice:
        """The samples of one dispatch."""
        return Slice(self._chunks, UNIFORM_ALIGNMENT * number, dtype(record.Chunk).itemsize)

    def _chunk_records(self) -> npt.NDArray[np.uint8]:
        rows = np.zeros((self.chunks, UNIFORM_ALIGNMENT), np.uint8)
        for number, row in enumerate(rows):
            first = number * self.per_chunk
            data = pack(record.Chunk(first_sample=first, sample_count=min(self.per_chunk, self.count - first)))
            row[: len(data)] = np.frombuffer(data, np.uint8)
        return rows

    def write(self, lights: Sequence[SampledLight]) -> None:
        """Write this frame's lights; `encode` takes them by their index."""
        contents = [
            pack(record.light_record(each.light, each.layer)) + pack(record.samples_record(each.points, each.weights))
            for each in lights
        ]
        self._selection.write(contents, "samples")

    def encode(self, encoder: wgpu.GPUCommandEncoder, index: int) -> None:
        """Select light `index`."""
        self._selection.encode(encoder, index)
