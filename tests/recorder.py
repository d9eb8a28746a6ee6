"""What a renderer asks of the device, written down: commands of an encoder, and writes with what they depend on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
import wgpu
from wgpu.backends import wgpu_native

from softshadows.gpu.device import Gpu

ENCODERS = (wgpu_native.GPUCommandEncoder, wgpu_native.GPUComputePassEncoder, wgpu_native.GPURenderPassEncoder)
MADE_ANEW = ("GPUCommandEncoder", "GPUComputePassEncoder", "GPURenderPassEncoder", "GPUCommandBuffer")
"""Objects that every frame makes for itself: they go by their kind."""


@dataclass
class Recording:
    """commands: (method, arguments); writes: (buffer's label and identity, offset, bytes, what they depend on)."""

    commands: list[tuple[str, str]] = field(default_factory=list)
    writes: list[tuple[str, int, bytes, str]] = field(default_factory=list)

    def count(self, method: str) -> int:
        return sum(name == method for name, _ in self.commands)


def described(value: Any) -> str:
    """Equal for equal arguments: objects of the device by identity, everything else by value."""
    if isinstance(value, wgpu.GPUObjectBase):
        kind = type(value).__name__
        return kind if kind in MADE_ANEW else f"{kind} {value.label!r} {id(value):x}"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {described(item)}" for key, item in sorted(value.items())) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(described, value)) + "]"
    return repr(value)


@contextmanager
def recording(gpu: Gpu) -> Iterator[Recording]:
    """Write down all that happens on `gpu` in the meantime."""
    record = Recording()
    nested: list[str] = []

    def wrap(patch: pytest.MonkeyPatch, cls: type, method: str) -> None:
        original = getattr(cls, method)

        def recorded(self: Any, *arguments: Any, **named: Any) -> Any:
            if not nested:
                record.commands.append((method, described([*arguments, named])))
            nested.append(method)
            try:
                return original(self, *arguments, **named)
            finally:
                nested.pop()

        patch.setattr(cls, method, recorded)

    def listen(buffer: wgpu.GPUBuffer, offset: int, data: bytes | np.ndarray, what: str) -> None:
        record.writes.append((described(buffer), offset, bytes(data), what))

    with pytest.MonkeyPatch.context() as patch:
        for cls in ENCODERS:
            for method in dir(cls):
                if not method.startswith("_") and callable(getattr(cls, method)):
                    wrap(patch, cls, method)
        gpu.write_listeners.append(listen)
        try:
            yield record
        finally:
            gpu.write_listeners.remove(listen)
