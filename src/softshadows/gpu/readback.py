"""The one read-back of a frame: every result in one mapped buffer, closed by a completion word that is checked.

A driver that gives up on a long job can hand back an empty buffer without an error, so the last thing a frame does on
the GPU is to write the frame's number after its results.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import wgpu

from softshadows.errors import DeviceError
from softshadows.gpu.device import Gpu
from softshadows.gpu.program import Program

_ROW_ALIGNMENT = 256  # WebGPU: bytes per row of a texture-to-buffer copy


@dataclass(frozen=True)
class _Part:
    name: str
    source: wgpu.GPUTexture | wgpu.GPUBuffer
    dtype: np.dtype
    shape: tuple[int, ...]
    offset: int
    row_bytes: int  # 0 for buffers; padded bytes per row for textures


class Readback:
    """A staging buffer with named parts. Built once per renderer, used once per frame."""

    def __init__(self, gpu: Gpu) -> None:
        self._gpu = gpu
        self._parts: list[_Part] = []
        self._size = 0
        self._staging: wgpu.GPUBuffer | None = None
        self._frame = 0
        usage = wgpu.BufferUsage
        self._word = gpu.device.create_buffer(size=16, usage=usage.STORAGE | usage.COPY_SRC)
        self._number = gpu.device.create_buffer(size=16, usage=usage.UNIFORM | usage.COPY_DST)
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

    def add_buffer(self, name: str, buffer: wgpu.GPUBuffer, dtype: str, shape: tuple[int, ...]) -> None:
        size = int(np.prod(shape)) * np.dtype(dtype).itemsize
        self._add(_Part(name, buffer, np.dtype(dtype), shape, self._size, 0), -(-size // 16) * 16)

    def _add(self, part: _Part, size: int) -> None:
        self._parts.append(part)
        self._size += -(-size // _ROW_ALIGNMENT) * _ROW_ALIGNMENT

    def encode(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Copy all parts, then let the GPU write this frame's number behind them."""
        if self._staging is None:
            usage = wgpu.BufferUsage.MAP_READ | wgpu.BufferUsage.COPY_DST
            self._staging = self._gpu.device.create_buffer(size=self._size + 16, usage=usage)
        for part in self._parts:
            if isinstance(part.source, wgpu.GPUBuffer):
                size = int(np.prod(part.shape)) * part.dtype.itemsize
                encoder.copy_buffer_to_buffer(part.source, 0, self._staging, part.offset, size)
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
        self._gpu.device.queue.write_buffer(self._number, 0, np.array([self._frame, 0, 0, 0], np.uint32))
        compute = encoder.begin_compute_pass(label="completion")
        self._complete.dispatch(compute, (1,))
        compute.end()
        encoder.copy_buffer_to_buffer(self._word, 0, self._staging, self._size, 16)

    def read(self) -> dict[str, np.ndarray]:
        """Wait for the frame and return its parts by name, as arrays of their own.

        Raises DeviceError where the completion word is missing: the GPU did not finish the frame.
        """
        assert self._staging is not None, "encode() comes before read()"
        self._staging.map_sync(wgpu.MapMode.READ)
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


def _extract(data: np.ndarray, part: _Part) -> np.ndarray:
    if part.row_bytes == 0:
        size = int(np.prod(part.shape)) * part.dtype.itemsize
        return data[part.offset : part.offset + size].view(part.dtype).reshape(part.shape).copy()
    height, width, channels = part.shape
    rows = data[part.offset : part.offset + height * part.row_bytes].reshape(height, part.row_bytes)
    pixels = rows[:, : width * channels * part.dtype.itemsize].copy()  # also where the rows are contiguous as they lie
    return pixels.view(part.dtype).reshape(part.shape)
