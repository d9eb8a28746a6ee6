"""The techniques, by name. Adding one: its folder, and its line in this list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from softshadows.errors import OptionError
from softshadows.techniques.adaptive.adaptive import Adaptive, CellFilter, NoFilter, PcfFilter
from softshadows.techniques.base import Technique
from softshadows.techniques.bitmask.bitmask import Bitmask
from softshadows.techniques.common_options import Hybrid, Maps, Rays, WholeLight
from softshadows.techniques.hard.hard import Hard
from softshadows.techniques.line_shadow_maps.line_shadow_maps import AutoSamples, LineShadowMaps
from softshadows.techniques.none.none import Unshadowed
from softshadows.techniques.occluding_edges.occluding_edges import Ends, OccludingEdges, Searched, Texture
from softshadows.techniques.pcf.pcf import Pcf
from softshadows.techniques.pcss.pcss import Pcss
from softshadows.techniques.penumbra_wedges.penumbra_wedges import (
    Additive,
    Overlap,
    PenumbraWedges,
    Probabilistic,
    Union,
)
from softshadows.techniques.uniform.uniform import Uniform
from softshadows.techniques.variable_penumbra.variable_penumbra import Bands, Fixed, FromLight, VariablePenumbra
from softshadows.techniques.vsm.vsm import Vsm

TECHNIQUES: dict[str, type[Technique]] = {
    cls.name: cls
    for cls in (
        Unshadowed,
        Hard,
        Pcf,
        Pcss,
        Vsm,
        Uniform,
        Adaptive,
        Bitmask,
        VariablePenumbra,
        LineShadowMaps,
        OccludingEdges,
        PenumbraWedges,
    )
}

DEFAULT = "bitmask"
"""The technique where none is named: it does every light and every scene, without bias or resolution to choose."""

__all__ = [
    "DEFAULT",
    "TECHNIQUES",
    "Adaptive",
    "Additive",
    "AutoSamples",
    "Bands",
    "Bitmask",
    "CellFilter",
    "Ends",
    "Fixed",
    "FromLight",
    "Hard",
    "Hybrid",
    "LineShadowMaps",
    "Maps",
    "NoFilter",
    "OccludingEdges",
    "Overlap",
    "Pcf",
    "PcfFilter",
    "Pcss",
    "PenumbraWedges",
    "Probabilistic",
    "Rays",
    "Searched",
    "Technique",
    "Texture",
    "Uniform",
    "Union",
    "Unshadowed",
    "VariablePenumbra",
    "Vsm",
    "WholeLight",
    "make_technique",
]


def make_technique(name: str, options: Mapping[str, Any] | None = None) -> Technique:
    """The technique `name` with `options` by name, such as `{"preset": "paper", "kernels.taps": "49"}`.

    Values may be text, as from a command line (see Technique.of). Raises OptionError for an unknown technique or
    option, or a value out of range, with the legal ones.
    """
    if name not in TECHNIQUES:
        raise OptionError(f"there is no technique {name!r}; choose one of {', '.join(TECHNIQUES)}")
    return TECHNIQUES[name].of(options or {})
