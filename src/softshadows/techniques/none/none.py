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

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import shader_module
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
        device = context.gpu.device
        module = shader_module(device, Path(__file__).with_name("none.wgsl"))
        self._pipeline = device.create_compute_pipeline(
            layout="auto", compute={"module": module, "entry_point": "cs_fill"}
        )
        self._bindings = device.create_bind_group(
            layout=self._pipeline.get_bind_group_layout(0),
            entries=[{"binding": 0, "resource": {"buffer": context.visibility}}],
        )
        self._groups = -(-context.visibility.size // 4 // 256)

    def set_lights(self, lights: Sequence[Light]) -> None:
        pass  # all lights look the same

    def encode(self, commands: Commands) -> None:
        fill = commands.encoder.begin_compute_pass(timestamp_writes=commands.timer.writes("fill"))
        fill.set_pipeline(self._pipeline)
        fill.set_bind_group(0, self._bindings)
        rows = -(-self._groups // 65535)
        fill.dispatch_workgroups(min(self._groups, 65535), rows)
        fill.end()
