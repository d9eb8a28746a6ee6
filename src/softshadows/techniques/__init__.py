"""The techniques, by name. Adding one: its folder, and its line in this list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from softshadows.errors import OptionError
from softshadows.techniques.adaptive.adaptive import Adaptive
from softshadows.techniques.base import Technique
from softshadows.techniques.hard.hard import Hard
from softshadows.techniques.line_shadow_maps.line_shadow_maps import LineShadowMaps
from softshadows.techniques.none.none import Unshadowed
from softshadows.techniques.occluding_edges.occluding_edges import OccludingEdges
from softshadows.techniques.pcf.pcf import Pcf
from softshadows.techniques.pcss.pcss import Pcss
from softshadows.techniques.penumbra_wedges.penumbra_wedges import PenumbraWedges
from softshadows.techniques.uniform.uniform import Uniform
from softshadows.techniques.variable_penumbra.variable_penumbra import VariablePenumbra
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
        VariablePenumbra,
        LineShadowMaps,
        OccludingEdges,
        PenumbraWedges,
    )
}

__all__ = [
    "TECHNIQUES",
    "Adaptive",
    "Hard",
    "LineShadowMaps",
    "OccludingEdges",
    "Pcf",
    "Pcss",
    "PenumbraWedges",
    "Technique",
    "Uniform",
    "Unshadowed",
    "VariablePenumbra",
    "Vsm",
    "make_technique",
]


def make_technique(name: str, options: Mapping[str, Any] | None = None) -> Technique:
    """The technique `name` with `options` (values may be text, as from a command line).

    Raises OptionError for an unknown technique or option, or a value out of range, with the legal ones.
    """
    if name not in TECHNIQUES:
        raise OptionError(f"there is no technique {name!r}; choose one of {', '.join(TECHNIQUES)}")
    cls = TECHNIQUES[name]
    known = [option.name for option in cls.options()]
    for option_name in options or {}:
        if option_name not in known:
            raise OptionError(f"technique {name!r} has no option {option_name!r}; it has {', '.join(known) or 'none'}")
    return cls(**(options or {}))
