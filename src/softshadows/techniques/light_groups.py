"""The techniques of a frame: every light has one, and lights that have the same share a pass."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import wgpu

from softshadows.gpu.commands import Commands
from softshadows.scene.geometry import Geometry
from softshadows.scene.lights import Light
from softshadows.techniques.base import RenderContext, Technique, TechniquePass


class LightGroups:
    """One pass per technique at work. `technique_of` names the technique of a light by its index."""

    def __init__(self, context: RenderContext, technique_of: Callable[[int], Technique]) -> None:
        self._context, self._technique_of = context, technique_of
        self._passes: dict[Technique, TechniquePass] = {}
        self._written: dict[Technique, tuple[tuple[tuple[int, Light], ...], Geometry, int, bool]] = {}
        self._at_work: list[TechniquePass] = []

    def prepare(self, light_count: int) -> None:
        """Build the passes that so many lights ask for, where they are not there yet."""
        for technique in dict.fromkeys(self._technique_of(index) for index in range(max(light_count, 1))):
            if technique not in self._passes:
                self._passes[technique] = technique.build(self._context)

    def write(self, lights: Sequence[Light], refinements: int = 0, *, keeps_looser_fits: bool = False) -> None:
        """Give every pass its lights, where they or the nodes have moved since it was last written, and say how their
        samples and maps depend on the frames before (base.py).
        """
        groups: dict[Technique, dict[int, Light]] = {}
        for index, light in enumerate(lights):
            groups.setdefault(self._technique_of(index), {})[index] = light
        self._at_work = [self._passes[technique] for technique in groups]
        geometry = self._context.scene.geometry
        for technique, group in groups.items():
            wanted = (tuple(group.items()), geometry, refinements, keeps_looser_fits)
            if wanted != self._written.get(technique):
                each = self._passes[technique]
                each.refinements, each.keeps_looser_fits = refinements, keeps_looser_fits
                each.write(group)
                self._written[technique] = wanted

    def encode(self, commands: Commands) -> None:
        for each in self._at_work:
            each.encode(commands)

    @property
    def passes(self) -> list[TechniquePass]:
        """All that have been built."""
        return [*self._passes.values()]

    @property
    def results(self) -> Mapping[str, tuple[wgpu.GPUBuffer, str, tuple[int, ...]]]:
        """The passes' results, for the read-back."""
        return {
            f"{number}.{name}": result
            for number, each in enumerate(self._passes.values())
            for name, result in each.results.items()
        }

    def read(self, results: Mapping[str, np.ndarray]) -> None:
        """Hand every pass its own."""
        for number, each in enumerate(self._passes.values()):
            each.read({name: results[f"{number}.{name}"] for name in each.results})

    @property
    def shadow_maps(self) -> int:
        return sum(each.shadow_maps for each in self._at_work)

    @property
    def lookups_per_pixel(self) -> float:
        return sum(each.lookups_per_pixel for each in self._at_work)

    @property
    def warnings(self) -> list[str]:
        return [warning for each in self._at_work for warning in each.warnings]

    @property
    def bytes(self) -> int:
        return sum(each.bytes for each in self._passes.values())
