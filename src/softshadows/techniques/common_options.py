"""Options that several techniques have: declared once, so that they mean the same everywhere."""

from __future__ import annotations

from typing import Any

from softshadows.lights.jitter import OFFSETS
from softshadows.techniques.base import VISIBILITIES, option

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


def visibility_option() -> Any:
    """`visibility: str`, of techniques that ask for samples of the light one by one."""
    return option(
        default="map",
        help="what tells whether a sample is visible: shadow maps, rays, or rays where the maps are not certain",
        choices=VISIBILITIES,
    )


def offsets_option() -> Any:
    """`offsets: str`, for visibility="ray" (traced.check_ray_options)."""
    return option(
        default="none",
        help="where rays' samples lie in their cells: the same for all pixels, or another place in each of 4×4",
        choices=OFFSETS,
    )


def denoise_option() -> Any:
    """`denoise: bool`, for visibility="ray" (traced.check_ray_options)."""
    return option(
        default=False,
        help="average rays' visibility over 4×4 pixels of a surface where it differs by no more than noise",
        choices=(False, True),
    )
