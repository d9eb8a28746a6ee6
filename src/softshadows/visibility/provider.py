"""Who answers "Is light sample s visible from p?": shadow maps, rays, or maps with rays where they are not certain.

A provider works for lights with one number of samples, one light and one chunk of samples at a time; query.wgsl says
what its shaders declare.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Resource
from softshadows.lights.sample_sets import SampledLight, SampleSet


class Provider(ABC):
    """See the module. `samples` holds the light whose turn it is and its samples."""

    samples: SampleSet

    @property
    @abstractmethod
    def bytes(self) -> int:
        """What its buffers and textures take, without those that it shares."""

    @property
    def can_cache(self) -> bool:
        """Can it cache maps from frame to frame, if it has one light alone?"""
        return False

    @property
    @abstractmethod
    def resources(self) -> Mapping[str, Resource]:
        """What its shaders declare, by name, but for `chunk`."""

    @property
    @abstractmethod
    def chunk_ms(self) -> float:
        """What a chunk takes, by the device's rough speeds, without the look-ups into maps."""

    @abstractmethod
    def write(self, lights: Sequence[SampledLight], *, keeps_looser_fits: bool = False) -> None:
        """Write this frame's lights; `encode_selection` takes them by their index.

        With `keeps_looser_fits` a map may serve that a new renderer would fit more tightly.
        """

    def encode_frame(self, commands: Commands) -> None:  # noqa: B027, maps have nothing to do
        """Encode what comes before a frame's first light."""

    @abstractmethod
    def encode_selection(self, commands: Commands, index: int) -> None:
        """Select light `index`."""

    def encode_chunk(self, commands: Commands, chunk: int) -> None:  # noqa: B027, nor have rays
        """Encode what comes before the look-ups of a chunk."""
