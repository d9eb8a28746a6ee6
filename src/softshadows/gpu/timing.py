"""GPU milliseconds per pass, from timestamp queries resolved in the frame's one read-back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import wgpu

from softshadows.gpu.device import Gpu

CAPACITY = 512
"""Timestamps kept in one frame; passes beyond half of it go untimed and are counted in `untimed`."""


class PassTimer:
    """Hands out `timestamp_writes` for passes by name; times of passes with the same name add up."""

    def __init__(self, gpu: Gpu) -> None:
        self.enabled = "timestamp-query" in gpu.features
        self.names: list[str] = []
        self.untimed = 0
        if self.enabled:
            self._queries = gpu.timestamps(CAPACITY)
            self.buffer = gpu.buffer(8 * CAPACITY, wgpu.BufferUsage.QUERY_RESOLVE, "the timestamps")

    def begin_frame(self) -> None:
        self.names.clear()
        self.untimed = 0

    def writes(self, name: str) -> dict | None:
        """The `timestamp_writes` argument of the next pass, or None where it cannot be timed."""
        if not self.enabled:
            return None
        if 2 * len(self.names) >= CAPACITY:
            self.untimed += 1
            return None
        index = 2 * len(self.names)
        self.names.append(name)
        return {
            "query_set": self._queries,
            "beginning_of_pass_write_index": index,
            "end_of_pass_write_index": index + 1,
        }

    def resolve(self, encoder: wgpu.GPUCommandEncoder) -> None:
        if self.names:
            encoder.resolve_query_set(self._queries, 0, 2 * len(self.names), self.buffer, 0)


def milliseconds(names: Sequence[str], stamps: np.ndarray) -> dict[str, float]:
    """`stamps` (2 × passes,) uint64 nanoseconds, as resolved, to milliseconds by the names of the passes."""
    result: dict[str, float] = {}
    for index, name in enumerate(names):
        duration = int(stamps[2 * index + 1]) - int(stamps[2 * index])
        result[name] = result.get(name, 0.0) + max(duration, 0) / 1e6
    return result
