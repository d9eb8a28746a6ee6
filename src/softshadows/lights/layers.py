"""Which layers of visibility a pass works on: the lights' places among the frame's lights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer


class Layers:
    """array<u32>, bound as `buffer`; a dispatch takes `count` of them along z."""

    def __init__(self, gpu: Gpu) -> None:
        self._gpu = gpu
        self._written: list[int] = []
        self.buffer = GrowingBuffer(gpu, 16, "the layers of visibility")

    @property
    def count(self) -> int:
        return len(self._written)

    def write(self, layers: Sequence[int]) -> None:
        """Write the lights' places, where they are others than before."""
        if self._written != [*layers]:
            self._written = [*layers]
            self.buffer.hold(4 * self.count)
            self._gpu.write(self.buffer.buffer, 0, np.array(layers, np.uint32), what="light")
