"""What a technique is: a frozen dataclass of options that builds a pass, which turns receivers into visibility."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.lights import LIGHT_CLASSES, Light
from softshadows.techniques.options import Option, Options, all_options, build, flattened, overlaid

Presets = Mapping[str, Mapping[str, Any]]
"""A technique's named choices of options."""


DEFAULT_MEMORY_BUDGET = 512


def checked_budget(memory_budget: int) -> int:
    """OptionError for anything but a whole number of MiB."""
    if not isinstance(memory_budget, int) or isinstance(memory_budget, bool) or memory_budget < 1:
        raise OptionError(f"memory_budget must be a whole number of MiB, at least 1, got {memory_budget!r}")
    return memory_budget


@dataclass(frozen=True)
class RenderContext:
    """What every technique's pass may use. `visibility` is array<f32>, laid out [light][y][x].

    `memory_budget` is how many MiB the shadow maps drawn at one time may take.
    """

    gpu: Gpu
    scene: SceneBuffers
    gbuffer: GBuffer
    visibility: GrowingBuffer
    memory_budget: int = DEFAULT_MEMORY_BUDGET


class TechniquePass(ABC):
    """A technique at work: keeps its GPU state between frames.

    `refinements` counts the frames that `Renderer.refine` has averaged: a technique that samples the light then takes
    other points (jitter.py). With `keeps_looser_fits`, as `Renderer.draw` sets it, shadow maps of an earlier frame
    serve as long as they show all that this one sees, though a new renderer would fit them more tightly.
    """

    bytes: int = 0
    shadow_maps: int = 0
    lookups_per_pixel: float = 0.0
    refinements: int = 0
    keeps_looser_fits: bool = False

    def __init__(self) -> None:
        self.warnings: list[str] = []

    @abstractmethod
    def write(self, lights: Mapping[int, Light]) -> None:
        """Write what the frame needs to know of the pass's lights. Before encode, unless nothing that it depends on has
        changed since: lights, nodes, `refinements`, `keeps_looser_fits`.

        Each comes with its place among the frame's lights, which is that of its layer of visibility.
        """

    @abstractmethod
    def encode(self, commands: Commands) -> None:
        """Encode everything that fills these lights' visibility."""

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        """Buffers, with dtype and shape, that the frame's read-back brings along with its images, by name."""
        return {}

    def read(self, results: Mapping[str, np.ndarray]) -> None:  # noqa: B027, most have nothing to learn
        """Learn from `results` what only the GPU knew of the frame: maps, look-ups, warnings."""


class Technique(Options, ABC):
    """Base of the techniques. A subclass names itself, the lights it can do, its options, and builds its pass."""

    light_kinds: ClassVar[frozenset[str]]
    presets: ClassVar[Presets] = {}
    refines: ClassVar[bool] = False
    """Does it take other samples of the light in every frame that is refined?"""

    @classmethod
    def options(cls) -> tuple[Option, ...]:
        """All options, in order: those of a choice follow it, with names such as `kernels.taps`."""
        return tuple(all_options(cls))

    @classmethod
    def preset(cls, name: str) -> Self:
        """A named choice of options. Raises OptionError for an unknown name."""
        return cls.of({"preset": name})

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """The technique with options by name; values may be text.

        `preset` comes first, then the single options: `{"preset": "paper", "kernels": "fixed", "kernels.size": "7"}` or
        `{"kernels": {"type": "fixed", "size": 7}}`. Raises OptionError for an unknown or illegal one.
        """
        single = flattened(given)
        name = single.pop("preset", None)
        if name is not None and name not in cls.presets:
            raise OptionError(f"{cls.name} has no preset {name!r}; choose one of {', '.join(cls.presets) or 'none'}")
        return build(cls, overlaid(cls.presets[name] if name is not None else {}, single))

    @classmethod
    def check_lights(cls, lights: Sequence[Light]) -> None:
        """OptionError where a light is of a kind this technique cannot do."""
        for index, light in enumerate(lights):
            if light.kind not in cls.light_kinds:
                raise OptionError(
                    f"technique {cls.name!r} cannot do light {index}, a {light.kind} light; "
                    f"it does {', '.join(sorted(cls.light_kinds))}. Choose another technique or light."
                )

    @abstractmethod
    def build(self, context: RenderContext) -> TechniquePass:
        """The technique's pass on this device, scene and image size."""


ALL_LIGHTS = frozenset(LIGHT_CLASSES)
