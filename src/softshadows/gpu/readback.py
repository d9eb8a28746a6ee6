"""The one read-back of a frame: every result in one mapped buffer, closed by a completion word that is checked.

A driver that gives up on a long job can hand back an empty buffer without an error, so the last thing a frame does on
the GPU is to write the frame's number after its results. Images are waited for; statistics are not (StatisticsRing).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import wgpu

from softshadows.errors import DeviceError
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.program import Program

_ROW_ALIGNMENT = 256  # WebGPU: bytes per row of a texture-to-buffer copy
RING = 3
"""Frames of which statistics may be under way at one time."""


@dataclass(frozen=True)
class _Part:
    name: str
    source: wgpu.GPUTexture | wgpu.GPUBuffer | GrowingBuffer
    dtype: np.dtype
    shape: tuple[int, ...]
    offset: int
    row_bytes: int  # 0 for buffers; padded bytes per row for textures


class Readback:
    """A staging buffer with named parts, used once per frame."""

    def __init__(self, gpu: Gpu) -> None:
        self._gpu = gpu
        self._parts: list[_Part] = []
        self._size = 0
        self._staging: wgpu.GPUBuffer | None = None
        self._mapping: wgpu.GPUPromise[None] | None = None
        self._frame = 0
        self._word = gpu.storage_buffer(16, "the completion word")
        self._number = gpu.buffer(16, wgpu.BufferUsage.UNIFORM, "the frame's number")
        resources = {"frame_number": self._number, "completion_word": self._word}
        self._complete = Program(gpu, "gpu/completion.wgsl", "cs_complete", resources)

    @property
    def size(self) -> int:
        """Bytes of the staging buffer."""
        return self._size

    def add_texture(self, name: str, texture: wgpu.GPUTexture, dtype: str, channels: int) -> None:
        width, height, _ = texture.size
        texel = np.dtype(dtype).itemsize * channels
        row = -(-width * texel // _ROW_ALIGNMENT) * _ROW_ALIGNMENT
        self._add(_Part(name, texture, np.dtype(dtype), (height, width, channels), self._size, row), row * height)

    def add_buffer(self, name: str, buffer: wgpu.GPUBuffer | GrowingBuffer, dtype: str, shape: tuple[int, ...]) -> None:
        size = int(np.prod(shape)) * np.dtype(dtype).itemsize
        self._add(_Part(name, buffer, np.dtype(dtype), shape, self._size, 0), -(-size // 16) * 16)

    def _add(self, part: _Part, size: int) -> None:
        self._parts.append(part)
        self._size += -(-size // _ROW_ALIGNMENT) * _ROW_ALIGNMENT

    def encode(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Copy all parts, then let the GPU write this frame's number behind them."""
        if self._staging is None:
            self._staging = self._gpu.staging_buffer(self._size + 16, "what is read back")
        for part in self._parts:
            if not isinstance(part.source, wgpu.GPUTexture):
                size = int(np.prod(part.shape)) * part.dtype.itemsize
                buffer = part.source.buffer if isinstance(part.source, GrowingBuffer) else part.source
                encoder.copy_buffer_to_buffer(buffer, 0, self._staging, part.offset, size)
            else:
                height, width, _ = part.shape
                target = {
                    "buffer": self._staging,
                    "offset": part.offset,
                    "bytes_per_row": part.row_bytes,
                    "rows_per_image": height,
                }
                encoder.copy_texture_to_buffer({"texture": part.source}, target, (width, height, 1))
        self._frame = (self._frame + 1) & 0xFFFFFFFF
        self._gpu.write(self._number, 0, np.array([self._frame, 0, 0, 0], np.uint32), what="frame")
        compute = encoder.begin_compute_pass(label="completion")
        self._complete.dispatch(compute, (1,))
        compute.end()
        encoder.copy_buffer_to_buffer(self._word, 0, self._staging, self._size, 16)

    def start(self) -> None:
        """Ask for the parts of the frame just submitted without waiting; `read` waits where they are still pending."""
        assert self._staging is not None, "encode() comes before start()"
        self._mapping = self._staging.map_async(wgpu.MapMode.READ)

    @property
    def is_pending(self) -> bool:
        """Is the frame that was asked for still being drawn?"""
        # A promise of wgpu-py 0.32 tells its state to event loops alone; queue.on_submitted_work_done_sync is broken.
        return self._mapping is not None and self._mapping._state == "pending"

    def read(self) -> dict[str, np.ndarray]:
        """Wait for the frame and return its parts by name, as arrays of their own.

        Raises DeviceError where the completion word is missing: the GPU did not finish the frame.
        """
        assert self._staging is not None, "encode() comes before read()"
        if self._mapping is None:
            self._staging.map_sync(wgpu.MapMode.READ)
        else:
            mapping, self._mapping = self._mapping, None
            mapping.sync_wait()
        try:
            data = np.asarray(self._staging.read_mapped(copy=False)).view(np.uint8)
            word = int(data[self._size : self._size + 4].view(np.uint32)[0])
            if word != self._frame:
                raise DeviceError(
                    f"the GPU returned an unfinished frame (completion word {word}, expected {self._frame}); "
                    "the driver probably stopped a job that took too long. "
                    "Lower the size or the number of light samples."
                )
            return {part.name: _extract(data, part) for part in self._parts}
        finally:
            self._staging.unmap()


About = TypeVar("About")


class StatisticsRing(Generic[About]):
    """Small read-backs that nobody waits for: what frames cost, known some frames later.

    `make` builds one. A frame that finds all of them under way goes without. What the caller knows `about` a frame
    comes back with its parts.
    """

    def __init__(self, make: Callable[[], Readback]) -> None:
        self._free = [make() for _ in range(RING)]
        self._under_way: list[tuple[Readback, About]] = []
        self.size = sum(readback.size for readback in self._free)

    def encode(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """The last commands of a frame: copy its statistics, where a read-back is free."""
        if self._free:
            self._free[0].encode(encoder)

    def start(self, about: About) -> None:
        """After the submit: ask for them."""
        if self._free:
            readback = self._free.pop(0)
            readback.start()
            self._under_way.append((readback, about))

    def finished(self) -> tuple[dict[str, np.ndarray], About] | None:
        """Parts of the last frame that has finished since the last call, or None. Raises DeviceError as `read`."""
        found = None
        while self._under_way and not self._under_way[0][0].is_pending:
            readback, about = self._under_way.pop(0)
            self._free.append(readback)
            found = readback.read(), about
        return found


def _extract(data: np.ndarray, part: _Part) -> np.ndarray:
    if part.row_bytes == 0:
        size = int(np.prod(part.shape)) * part.dtype.itemsize
        return data[part.offset : part.offset + size].view(part.dtype).reshape(part.shape).copy()
    height, width, channels = part.shape
    rows = data[part.offset : part.offset + height * part.row_bytes].reshape(height, part.row_bytes)
    pixels = rows[:, : width * channels * part.dtype.itemsize].copy()  # also where the rows are contiguous as they lie
    return pixels.view(part.dtype).reshape(part.shape)
