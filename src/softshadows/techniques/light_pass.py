"""A technique composed of three parts: where to sample lights, who answers for the samples, how answers are combined.

    sampling       lights/sample_sets.py        points on the light, and their weights
    source         visibility/sources.py        shadow maps, rays, or both
    combination    here, made by techniques     a shader that turns answers into visibility

Lights are interleaved, and so are the chunks of a light's samples: what one submit may draw, trace and look up.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Bindings, Program, Resource
from softshadows.lights.sample_sets import SampledLight, Sampling
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext, TechniquePass
from softshadows.techniques.workers import Workers, lights_of
from softshadows.visibility.maps.shadow_maps import MapOptions, ShadowMaps
from softshadows.visibility.provider import Provider
from softshadows.visibility.sources import MapSource, Source


class ChunkPrograms:
    """Entry points of one shader, bound to the chunks of whatever provider is at work.

    The shader declares `visibility`, `chunk`, the G-buffer's and the provider's resources, and those given here.
    """

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *entries: str,
        resources: Mapping[str, Resource] | None = None,
        constants: Mapping[str, float] | None = None,
        stand_ins: Mapping[str, str] | None = None,
    ) -> None:
        width, height = context.gbuffer.size
        self._image_groups = (-(-width // 8), -(-height // 8))
        fixed = {**context.gbuffer.resources, "visibility": context.visibility, **(resources or {})}
        self._programs = {
            entry: Program(context.gpu, shader, entry, fixed, constants=constants, stand_ins=stand_ins)
            for entry in entries
        }
        self._bindings: WeakKeyDictionary[Provider, dict[tuple[str, int], Bindings]] = WeakKeyDictionary()

    def encode(
        self,
        commands: Commands,
        label: str,
        entry: str,
        provider: Provider,
        chunk: int,
        *,
        groups: tuple[int, int] | None = None,
        beside: Mapping[str, Resource] | None = None,
    ) -> None:
        """Run an entry for a chunk of the provider's samples: workgroups of 8×8 pixels of the image, or `groups`.

        `beside` the provider's resources, the shader may declare others that come and go with the provider.
        """
        program, bindings = self._programs[entry], self._bindings.setdefault(provider, {})
        if (entry, chunk) not in bindings:
            resources = {**provider.resources, **(beside or {}), "chunk": provider.samples.chunk(chunk)}
            bindings[entry, chunk] = program.bind(**resources)
        with commands.compute(label) as compute:
            program.dispatch(compute, groups or self._image_groups, bindings[entry, chunk])


@dataclass(frozen=True)
class Found:
    """What a combination learned from a frame's results; None where it knew before."""

    lookups_per_pixel: float | None = None
    warnings: list[str] = field(default_factory=list)


ProviderT = TypeVar("ProviderT", bound=Provider)
AskedT = TypeVar("AskedT", bound=Provider, contravariant=True)


def map_source(
    context: RenderContext,
    resolution: int | str,
    options: MapOptions = MapOptions(),  # noqa: B008, it is frozen
    most_per_chunk: int | None = None,
) -> MapSource:
    """Shadow maps of a technique, within the renderer's budget."""
    gpu, scene, gbuffer, budget = context.gpu, context.scene, context.gbuffer, context.memory_budget
    return MapSource(gpu, scene, gbuffer, resolution, budget, options, most_per_chunk=most_per_chunk)


class Combination(ABC, Generic[AskedT]):
    """How a technique turns a provider's answers into visibility."""

    def __init__(self, context: RenderContext) -> None:
        self.context = context

    @property
    def bytes(self) -> int:
        """What its buffers and textures take."""
        return 0

    @abstractmethod
    def lookups(self, samples: int) -> float:
        """How often a pixel reads the maps of a light with so many samples, or traces rays to it."""

    def write(self, layers: Sequence[int]) -> None:
        """The next frames' lights, by their layers of visibility."""

    def lookup_ms(self, provider: AskedT) -> float:
        """What the look-ups of a chunk take, by the device's rough speeds, beside the provider's `chunk_ms`."""
        samples, (width, height) = provider.samples, self.context.gbuffer.size
        lookups = self.lookups(samples.count) / samples.count * samples.per_chunk
        return width * height * lookups / self.context.gpu.budget.lookups_per_ms

    def encode_frame(self, commands: Commands) -> None:
        """Encode what comes before a frame's first light."""

    @abstractmethod
    def encode(self, commands: Commands, provider: AskedT, chunk: int) -> None:
        """Turn a chunk of the provider's samples into visibility."""

    def encode_end(self, commands: Commands) -> None:
        """Encode what comes after the frame's last light."""

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        """As TechniquePass.results."""
        return {}

    def read(self, results: Mapping[str, np.ndarray], lights: int) -> Found:
        """Learn from the results of a frame with so many lights."""
        return Found()


class Lookups(Combination[ShadowMaps]):
    """One step per chunk of maps: the shader's `cs_visibility`. `per_pixel` counts the reads of so many samples."""

    def __init__(
        self,
        context: RenderContext,
        shader: str,
        *,
        per_pixel: Callable[[int], float] = float,
        resources: Mapping[str, wgpu.GPUBuffer] | None = None,
        constants: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(context)
        self._per_pixel, self._resources = per_pixel, dict(resources or {})
        self._programs = ChunkPrograms(context, shader, "cs_visibility", resources=self._resources, constants=constants)

    @property
    def bytes(self) -> int:
        return sum(buffer.size for buffer in self._resources.values())

    def lookups(self, samples: int) -> float:
        return self._per_pixel(samples)

    def encode(self, commands: Commands, provider: ShadowMaps, chunk: int) -> None:
        self._programs.encode(commands, "lookup", "cs_visibility", provider, chunk)


class LightPass(TechniquePass, Generic[ProviderT]):
    """See the module."""

    def __init__(
        self,
        context: RenderContext,
        sampling: Sampling,
        source: Source[ProviderT],
        combination: Combination[ProviderT],
    ) -> None:
        super().__init__()
        self._context, self._sampling = context, sampling
        self._source, self.combination = source, combination
        self._providers: Workers[int, ProviderT] = Workers(source.make, context.memory_budget)  # by samples per light
        self.by_light: list[tuple[ProviderT, int]] = []  # per light: its provider, and its index there

    def write(self, lights: Mapping[int, Light]) -> None:
        sampled = {layer: self._sampled(light, layer) for layer, light in lights.items()}
        by_light = self._providers.assign({layer: len(each.weights) for layer, each in sampled.items()})
        for provider, layers in lights_of(by_light).items():
            provider.write([sampled[layer] for layer in layers], keeps_looser_fits=self.keeps_looser_fits)
        self.combination.write([*lights])
        self.by_light = [*by_light.values()]
        counts = [provider.samples.count for provider, _ in self.by_light]
        self.shadow_maps = sum(counts) if self._source.draws_maps else 0
        self.lookups_per_pixel = float(sum(self.combination.lookups(count) for count in counts))

    def _sampled(self, light: Light, layer: int) -> SampledLight:
        points, weights = self._sampling.points(light, self.refinements)
        return SampledLight(light.without_size if self._sampling.ignores_size else light, layer, points, weights)

    def encode(self, commands: Commands) -> None:
        self.combination.encode_frame(commands)
        for provider in dict.fromkeys(provider for provider, _ in self.by_light):
            provider.encode_frame(commands)
        for provider, index in self.by_light:
            provider.encode_selection(commands, index)
            for chunk in range(provider.samples.chunks):
                provider.encode_chunk(commands, chunk)
                self.combination.encode(commands, provider, chunk)
                commands.account(provider.chunk_ms + self.combination.lookup_ms(provider))
        self.combination.encode_end(commands)
        self.bytes = self._source.shared_bytes + self.combination.bytes + self._providers.bytes

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        return self.combination.results

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        found = self.combination.read(results, len(self.by_light))
        self.warnings = found.warnings
        if found.lookups_per_pixel is not None:
            self.lookups_per_pixel = found.lookups_per_pixel
