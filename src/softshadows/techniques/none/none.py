"""No shadows: visibility 1 everywhere. What a picture costs and looks like without them.

Paper
    none.

Section map
    none.

Departures from the paper
    none.

Use when
    you want the cost of everything but the shadows, or the unshadowed picture of a shadow matte.
Fails when
    anything casts a shadow.
Inputs
    any light.
Cost
    one fill of the visibility buffer.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softshadows.gpu.commands import Commands
from softshadows.gpu.program import Program
from softshadows.lights.layers import Layers
from softshadows.scene.lights import Light
from softshadows.techniques.base import ALL_LIGHTS, RenderContext, Technique, TechniquePass


class Unshadowed(Technique):
    """No shadow: visibility 1 everywhere."""

    name: ClassVar[str] = "none"
    light_kinds: ClassVar[frozenset[str]] = ALL_LIGHTS

    def build(self, context: RenderContext) -> TechniquePass:
        return _FillPass(context)


class _FillPass(TechniquePass):
    def __init__(self, context: RenderContext) -> None:
        super().__init__()
        self._size, self._layers = context.gbuffer.size, Layers(context.gpu)
        resources = {"frame": context.gbuffer.uniforms, "visibility": context.visibility, "layers": self._layers.buffer}
        self._fill = Program(context.gpu, "techniques/none/none.wgsl", "cs_fill", resources)

    def write(self, lights: Mapping[int, Light]) -> None:
        self._layers.write([*lights])

    def encode(self, commands: Commands) -> None:
        width, height = self._size
        with commands.compute("fill") as compute:
            self._fill.dispatch(compute, (-(-width // 8), -(-height // 8), self._layers.count))
