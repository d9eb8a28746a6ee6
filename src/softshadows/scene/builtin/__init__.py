"""Scenes made in code, each with lights and a default camera: `softshadows.scenes.blocker()` and so on.

`SCENES` maps every name to its function; the first sentence of its docstring is its description.
"""

from __future__ import annotations

from collections.abc import Callable

from softshadows.errors import SceneError
from softshadows.scene.builtin.atrium import atrium
from softshadows.scene.builtin.leaves import leaves
from softshadows.scene.builtin.mannequin import mannequin
from softshadows.scene.builtin.room import room
from softshadows.scene.builtin.studies import blocker, fence, field, figures, sphere_cube
from softshadows.scene.model import Scene

SCENES: dict[str, Callable[..., Scene]] = {
    "blocker": blocker,
    "sphere_cube": sphere_cube,
    "figures": figures,
    "fence": fence,
    "leaves": leaves,
    "room": room,
    "field": field,
    "atrium": atrium,
    "mannequin": mannequin,
}

__all__ = [
    "SCENES",
    "atrium",
    "blocker",
    "describe",
    "fence",
    "field",
    "figures",
    "leaves",
    "make",
    "mannequin",
    "room",
    "sphere_cube",
]


def make(name: str) -> Scene:
    """The built-in scene called `name` with its default parameters; SceneError with the legal names for any other."""
    if name not in SCENES:
        raise SceneError(f"no built-in scene is called {name!r}; there are {', '.join(SCENES)}", code="SCENE_UNKNOWN")
    return SCENES[name]()


def describe(name: str) -> str:
    """The first sentence of a built-in scene's docstring."""
    return (SCENES[name].__doc__ or "").strip().splitlines()[0]
