"""What a technique is: a frozen dataclass of options that builds a pass, which turns receivers into visibility.

One declaration of an option gives `-O` flags, validation, documentation and the shader's constants.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, ClassVar, Self, dataclass_transform

import numpy as np
import wgpu

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.growing import GrowingBuffer
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.scene.lights import LIGHT_CLASSES, Light


def option(
    *,
    default: Any,
    help: str,
    choices: Sequence[Any] = (),
    low: float = -math.inf,
    high: float = math.inf,
    or_word: str | None = None,
    is_table: bool = False,
) -> Any:
    """A technique's option: its default, what it does, and its legal values.

    Either one of `choices`, or a number of the default's type in [low, high], or the word `or_word`. A default that is
    itself `or_word` means whole numbers. With `is_table` two or more numbers, as text with spaces between them.
    """
    return field(
        default=default,
        metadata={
            "help": help,
            "choices": tuple(choices),
            "low": low,
            "high": high,
            "or_word": or_word,
            "is_table": is_table,
        },
    )


def legal_values(option_field: Field) -> str:
    """The legal values of an option in words."""
    meta = option_field.metadata
    if meta["choices"]:
        return "one of " + ", ".join(str(choice) for choice in meta["choices"])
    kind = "a number" if isinstance(option_field.default, float) else "a whole number"
    if meta["is_table"]:
        kind = "two or more numbers, with spaces between them, each"
    interval = (
        f"from {meta['low']:.9g} to {meta['high']:.9g}" if meta["high"] < math.inf else f"of at least {meta['low']:.9g}"
    )
    return f"{kind} {interval}" + (f", or {meta['or_word']}" if meta["or_word"] else "")


def numbers_of(table: Any) -> list[float]:
    """The numbers of a table, given as text or one by one. Raises ValueError for anything else."""
    try:
        return [float(number) for number in (table.split() if isinstance(table, str) else table)]
    except TypeError:
        raise ValueError(f"not a table of numbers: {table!r}") from None


def _parse(option_field: Field, value: Any, owner: str) -> Any:
    """`value` (perhaps text from a command line) as the option's type, or OptionError."""
    meta = option_field.metadata
    error = OptionError(f"{owner}: {option_field.name} must be {legal_values(option_field)}; got {value!r}")
    if meta["choices"]:
        for choice in meta["choices"]:
            same_kind = isinstance(value, bool) == isinstance(choice, bool)
            if (value == choice and same_kind) or value in (str(choice), str(choice).lower()):
                return choice
        raise error
    if meta["or_word"] is not None and value == meta["or_word"]:
        return value
    if meta["is_table"]:
        try:
            numbers = numbers_of(value)
        except ValueError:
            raise error from None
        if len(numbers) < 2 or not all(meta["low"] <= number <= meta["high"] for number in numbers):
            raise error
        return " ".join(f"{number:.9g}" for number in numbers)
    kind = float if isinstance(option_field.default, float) else int
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise error
    try:
        number = kind(value)
    except (ValueError, OverflowError):
        raise error from None
    if not meta["low"] <= number <= meta["high"] or (not isinstance(value, str) and number != value):
        raise error
    return number


Presets = Mapping[str, Mapping[str, Any]]
"""A technique's named choices of options."""


@dataclass(frozen=True)
class RenderContext:
    """What every technique's pass may use. `visibility` is array<f32>, laid out [light][y][x]."""

    gpu: Gpu
    scene: SceneBuffers
    gbuffer: GBuffer
    visibility: GrowingBuffer


class TechniquePass(ABC):
    """A technique at work: keeps its GPU state between frames.

    `refinements` counts the frames that `Renderer.refine` has averaged: a technique that samples the light then takes
    other points (sub_positions.py).
    """

    bytes: int = 0
    shadow_maps: int = 0
    lookups_per_pixel: float = 0.0
    refinements: int = 0

    def __init__(self) -> None:
        self.warnings: list[str] = []

    @abstractmethod
    def set_lights(self, lights: Sequence[Light]) -> None:
        """Write what the frame needs to know of the lights. Before encode, every frame."""

    @abstractmethod
    def encode(self, commands: Commands) -> None:
        """Encode everything that fills every light's visibility."""

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        """Buffers, with dtype and shape, that the frame's read-back brings along with its images, by name."""
        return {}

    def take_results(self, results: Mapping[str, np.ndarray]) -> None:  # noqa: B027, most have nothing to learn
        """Learn from `results` what only the GPU knew of the frame: maps, look-ups, warnings."""


@dataclass_transform(frozen_default=True, field_specifiers=(option,))
class Technique(ABC):
    """Base of the techniques. A subclass names itself, the lights it can do, its options, and builds its pass."""

    name: ClassVar[str]
    light_kinds: ClassVar[frozenset[str]]
    presets: ClassVar[Presets] = {}
    refines: ClassVar[bool] = False
    """Does it take other samples of the light in every frame that is refined?"""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)

    def __post_init__(self) -> None:
        for option_field in fields(self):  # type: ignore[arg-type]
            value = _parse(option_field, getattr(self, option_field.name), self.name)
            object.__setattr__(self, option_field.name, value)

    @classmethod
    def options(cls) -> tuple[Field, ...]:
        """The option fields, in order; their metadata holds `help` and the legal values."""
        return tuple(f for f in fields(cls) if f.default is not MISSING)  # type: ignore[arg-type]

    @classmethod
    def preset(cls, name: str) -> Self:
        """A named choice of options. Raises OptionError for an unknown name."""
        if name not in cls.presets:
            raise OptionError(f"{cls.name} has no preset {name!r}; choose one of {', '.join(cls.presets) or 'none'}")
        return cls(**cls.presets[name])

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


VISIBILITIES = ("map", "ray", "hybrid")
"""What tells whether a light sample is visible, for techniques that ask sample by sample."""

ALL_LIGHTS = frozenset(LIGHT_CLASSES)
