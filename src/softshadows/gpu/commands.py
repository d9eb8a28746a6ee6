"""The frame's command stream: one submit, unless it is cut so that no submit runs into a driver's watchdog.

Where it is cut depends only on sizes the CPU knows, never on anything the GPU computed.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import wgpu

from softshadows.gpu.budget import SUBMIT_MS
from softshadows.gpu.device import Gpu
from softshadows.gpu.timing import PassTimer


class Commands:
    """`encoder` takes the next pass; `account(ms)` after an expensive one cuts the stream where it has grown long.

    `timer` times the passes of one stream at a time.
    """

    def __init__(self, gpu: Gpu, timer: PassTimer) -> None:
        self._gpu, self.timer = gpu, timer
        timer.begin_frame()
        self.encoder = gpu.device.create_command_encoder()
        self.submits = 0
        self.submit_seconds = 0.0
        self._finished: list[wgpu.GPUCommandBuffer] = []
        self._pending_ms = 0.0

    @contextmanager
    def compute(self, name: str) -> Iterator[wgpu.GPUComputePassEncoder]:
        """A compute pass, timed under `name`."""
        compute = self.encoder.begin_compute_pass(timestamp_writes=self.timer.writes(name))
        yield compute
        compute.end()

    @contextmanager
    def draw(self, name: str, **attachments: Any) -> Iterator[wgpu.GPURenderPassEncoder]:
        """A render pass into `attachments`, as begin_render_pass takes them, timed under `name`."""
        draw = self.encoder.begin_render_pass(timestamp_writes=self.timer.writes(name), **attachments)
        yield draw
        draw.end()

    def account(self, milliseconds: float) -> None:
        """Count work just encoded; starts a new submit when what is pending reaches SUBMIT_MS."""
        self._pending_ms += milliseconds
        if self._pending_ms >= SUBMIT_MS:
            self._finished.append(self.encoder.finish())
            self.encoder = self._gpu.device.create_command_encoder()
            self._pending_ms = 0.0

    def submit(self) -> None:
        """Hand the whole frame to the driver, submit by submit.

        Timed apart from encoding: a software driver works on a submit before it returns, and leaves cold caches behind.
        """
        self._finished.append(self.encoder.finish())
        started = time.thread_time()
        for commands in self._finished:
            self._gpu.device.queue.submit([commands])
        self.submit_seconds = time.thread_time() - started
        self.submits = len(self._finished)
