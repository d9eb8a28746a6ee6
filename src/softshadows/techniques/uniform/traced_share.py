"""The weighted share of a light's samples that each pixel sees, by rays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.techniques.base import RenderContext
from softshadows.techniques.light_pass import ChunkPrograms, Combination, Found
from softshadows.visibility.denoise.denoise import Denoise
from softshadows.visibility.provider import Provider
from softshadows.visibility.rays.tree import CUT_SHORT
from softshadows.visibility.sources import HybridSource, RaySource


class TracedShare(Combination[Provider]):
    """One ray per sample, where maps do not tell. Visibility that is off by `noise` is filtered."""

    def __init__(self, context: RenderContext, source: RaySource | HybridSource, noise: float | None) -> None:
        super().__init__(context)
        self._report = context.gpu.storage_buffer(4, "the rays' report")
        self._programs = ChunkPrograms(
            context,
            "techniques/uniform/trace.wgsl",
            "cs_trace",
            resources={"report": self._report},
            stand_ins=source.stand_ins,
        )
        self._denoise = Denoise(context.gpu, context.gbuffer, context.visibility, noise) if noise else None

    @property
    def bytes(self) -> int:
        return self._report.size + (self._denoise.bytes if self._denoise is not None else 0)

    def lookups(self, samples: int) -> float:
        return float(samples)

    def lookup_ms(self, provider: Provider) -> float:
        return 0.0  # the rays' time holds it

    def write(self, layers: Sequence[int]) -> None:
        if self._denoise is not None:
            self._denoise.write(layers)

    def encode_frame(self, commands: Commands) -> None:
        commands.encoder.clear_buffer(self._report)

    def encode(self, commands: Commands, provider: Provider, chunk: int) -> None:
        self._programs.encode(commands, "trace", "cs_trace", provider, chunk)

    def encode_end(self, commands: Commands) -> None:
        if self._denoise is not None:
            self._denoise.encode(commands)

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return {"report": (self._report, "<u4", (1,))}

    def read(self, results: Mapping[str, np.ndarray], lights: int) -> Found:
        return Found(warnings=[CUT_SHORT] if results["report"][0] else [])
