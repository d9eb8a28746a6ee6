"""Buffers that hold one of several contents: all are written at once, and the selected one is copied in."""

from __future__ import annotations

from collections.abc import Sequence

import wgpu

from softshadows.gpu.device import Dependency, Gpu
from softshadows.gpu.growing import GrowingBuffer


class Selection:
    """Where the contents go, as buffers and offsets: each part fills its buffer from there to the end."""

    def __init__(self, gpu: Gpu, places: Sequence[tuple[wgpu.GPUBuffer, int]]) -> None:
        self._gpu, self._places = gpu, places
        self._stride = sum(buffer.size - offset for buffer, offset in places)
        self._written = GrowingBuffer(gpu, self._stride, "contents to select from")

    @property
    def bytes(self) -> int:
        """What the written contents take."""
        return self._written.size

    def write(self, contents: Sequence[bytes], what: Dependency) -> None:
        """What each turn copies in: the parts, one after the other."""
        assert all(len(content) == self._stride for content in contents)
        self._written.hold(self._stride * len(contents))
        if contents:
            self._gpu.write(self._written.buffer, 0, b"".join(contents), what=what)

    def encode(self, encoder: wgpu.GPUCommandEncoder, index: int) -> None:
        """Select the contents of number `index`."""
        at = index * self._stride
        for buffer, offset in self._places:
            size = buffer.size - offset
            encoder.copy_buffer_to_buffer(self._written.buffer, at, buffer, offset, size)
            at += size
