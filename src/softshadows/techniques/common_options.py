"""Options that several techniques have: declared once, so that they mean the same everywhere."""

from __future__ import annotations

from typing import Any, ClassVar

from softshadows.errors import OptionError
from softshadows.lights.jitter import OFFSETS
from softshadows.techniques.options import Choice, one_of, option


def resolution_option(default: int | str, *, high: int = 16384) -> Any:
    """`resolution: int | str`."""
    return option(default=default, help="texels along a shadow map's side", low=16, high=high, or_word="auto")


def offsets_option() -> Any:
    """`offsets: str`."""
    return option(
        default="none",
        help="where samples lie in their cells: the same for all pixels, or another place in each of 4×4",
        choices=OFFSETS,
    )


def denoise_option() -> Any:
    """`denoise: bool`."""
    return option(
        default=False,
        help="average visibility over 4×4 pixels of a surface where it differs by no more than noise",
        choices=(False, True),
    )


class Maps(Choice):
    """Shadow maps: a sample is visible where nothing in its map lies before the receiver."""

    name: ClassVar[str] = "map"


class Rays(Choice):
    """A ray from the receiver to every sample."""

    name: ClassVar[str] = "ray"

    offsets: str = offsets_option()
    denoise: bool = denoise_option()


class Hybrid(Choice):
    """Shadow maps, and rays where the maps are not certain."""

    name: ClassVar[str] = "hybrid"


VISIBILITIES = one_of(Maps, Rays, Hybrid)
VISIBILITY_HELP = "what tells whether a sample is visible: shadow maps, rays, or rays where the maps are not certain"


def check_resolution(technique: str, visibility: Maps | Rays | Hybrid, resolution: int | str) -> None:
    """OptionError for a resolution of maps where there are none."""
    if isinstance(visibility, Rays) and resolution != "auto":
        raise OptionError(
            f"{technique}: resolution={resolution} is of shadow maps, and visibility=ray has none. "
            "Use visibility=map or hybrid, or leave it out."
        )


class WholeLight(Choice):
    """All visible parts of the light count alike."""

    name: ClassVar[str] = "whole"


SHADING_HELP = (
    "how visible parts of a line light are weighed: alike, or by the illumination at the ends of their segment, as in "
    "the paper"
)
"""Help of an option that the two techniques have which know what part is visible (visibility/line_maps/ends.wgsl)."""
