"""Options that several techniques have: declared once, so that they mean the same everywhere."""

from __future__ import annotations

from typing import Any

from softshadows.techniques.base import option

DEFAULT_MEMORY_BUDGET = 512
"""MiB that the shadow maps drawn at one time may take."""


def resolution_option(default: int | str, *, high: int = 16384) -> Any:
    """`resolution: int | str`."""
    return option(default=default, help="texels along a shadow map's side", low=16, high=high, or_word="auto")


def bias_option() -> Any:
    """`bias_scale: float`."""
    return option(default=1.0, help="factor on the automatic bias, for experts", low=0.0, high=1000.0)


def budget_option(holding: str) -> Any:
    """`memory_budget: int`, of which `holding` says for what."""
    return option(default=DEFAULT_MEMORY_BUDGET, help=f"MiB for {holding}", low=1, high=65536)


def shading_option() -> Any:
    """`shading: str`, of line lights (passes/line_maps/ends.wgsl)."""
    return option(
        default="whole",
        help="how visible parts of the light are weighed: alike, or by the illumination at the ends of their segment, "
        "as in the paper",
        choices=("whole", "ends"),
    )
