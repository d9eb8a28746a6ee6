"""Techniques chosen in words: `-t pcss,adaptive:preset=paper -O resolution=512`, over what a shot says."""

from __future__ import annotations

from softshadows.errors import OptionError
from softshadows.scene.shot import Shot
from softshadows.techniques import DEFAULT, TECHNIQUES, Technique, make_technique
from softshadows.techniques.options import flattened, overlaid


def technique_from(shot: Shot, name: str | None, options: list[str]) -> Technique:
    """The technique of -t and -O over the shot's; the default where neither names one."""
    given = dict(_option(text) for text in options)
    if shot.technique is not None and name in (None, shot.technique.name):
        return make_technique(shot.technique.name, overlaid(flattened(shot.technique.options), given))
    try:
        return make_technique(name or DEFAULT, given)
    except OptionError as error:
        if name is not None:
            raise
        raise OptionError(f"{error}. That is the default technique; -t names another") from error


def techniques_from(shot: Shot, names: str | None, options: list[str]) -> list[Technique]:
    """The techniques to compare: those named, or all that can do the shot's lights."""
    if names is None:
        wanted = [cls.name for cls in TECHNIQUES.values() if can_do(cls, shot)]
    else:
        wanted = [name.strip() for name in names.split(",") if name.strip()]
    shared = dict(_option(text) for text in options)
    unused = set(shared)
    made = []
    for entry in wanted:
        name, *own = entry.split(":")
        technique = TECHNIQUES.get(name)
        known = {key: value for key, value in shared.items() if technique and _has(technique, key, value)}
        unused -= set(known)
        made.append(make_technique(name, overlaid(known, dict(map(_option, own)))))
    if unused:
        raise OptionError(f"-O {sorted(unused)[0]}: none of the techniques compared has this option")
    return made


def _has(technique: type[Technique], option: str, value: str) -> bool:
    """Whether a technique has an option, or a preset of this name."""
    if option == "preset":
        return value in technique.presets
    return option in {declared.name for declared in technique.options()}


def can_do(technique: Technique | type[Technique], shot: Shot) -> bool:
    """Whether a technique does all kinds of light of a shot."""
    try:
        technique.check_lights(shot.scene.lights)
    except OptionError:
        return False
    return True


def _option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise OptionError(f"an option is written NAME=VALUE, got {text!r}")
    return name.strip(), value.strip()
