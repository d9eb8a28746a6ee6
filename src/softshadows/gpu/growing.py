"""A buffer that grows with what it must hold, while the programs that bind it stay as they are."""

from __future__ import annotations

import wgpu

from softshadows.gpu.device import Gpu


class GrowingBuffer:
    """A storage buffer of `size` bytes or more. A program binds `buffer` as it is when it runs (program.py)."""

    def __init__(self, gpu: Gpu, size: int, what: str) -> None:
        self._gpu, self._what = gpu, what
        self.buffer = gpu.storage_buffer(size, what)

    @property
    def size(self) -> int:
        """Bytes."""
        return self.buffer.size

    def hold(self, size: int) -> None:
        """Make room for `size` bytes: a new buffer where the one there is too small; its contents are lost.

        DeviceError where so many bytes cannot be bound.
        """
        if self.size < size:
            larger = self._gpu.storage_buffer(size, self._what)
            self._gpu.destroy(self.buffer)
            self.buffer: wgpu.GPUBuffer = larger
