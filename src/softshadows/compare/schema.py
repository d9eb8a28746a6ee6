"""The shape of results.json, as results.py describes it: what every file has, and of which kind. More is allowed.

A shape is a type, a tuple of types, a dict of names that must be there, a list of one shape for every element, or
`Each`: a dict with any names and one shape for all values. JSON writes 1.0 as 1 at times: a float may be whole.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softshadows.compare.interleaved import Timing
from softshadows.compare.results import SCHEMA
from softshadows.errors import OptionError
from softshadows.metrics import Comparison

Shape = Any


@dataclass(frozen=True)
class Each:
    """Any names, and one shape for all values."""

    shape: Shape


NONE = type(None)
FIGURE = (float, str, NONE, dict)
NUMBERS = {field.name: float for field in dataclasses.fields(Comparison)}
TIMING = {field.name: float for field in dataclasses.fields(Timing)}

TECHNIQUE: Shape = {
    "label": str,
    "name": str,
    "options": dict,
    "shadow_maps": int,
    "lookups_per_pixel": float,
    "frame_ms": float,
    "times": Each(TIMING),
    "gpu_ms": Each(float),
    "cpu_ms": float,
    "gpu_bytes": int,
    "flip": (float, NONE),
    "warnings": [str],
    "figures": Each(FIGURE),
    "lights": [NUMBERS],
}
PICTURE: Shape = {
    "scene": str,
    "size": [int],
    "triangles": int,
    "camera": {"position": [float], "target": [float], "vertical_fov": float},
    "lights": [{"type": str}],
    "truth": {"samples": int, "standard_error": float, "seconds": float},
    "techniques": [TECHNIQUE],
    "skipped": [str],
    "figures": dict,
}
ENVIRONMENT: Shape = {
    "adapter": {"adapter": str, "backend": str, "driver": str, "features": [str], "limits": Each(int)},
    "cpu": str,
    "cpu_count": int,
    "system": str,
    "versions": Each((str, NONE)),
    "commit": (str, NONE),
}
RESULTS: Shape = {
    "schema": str,
    "created": str,
    "environment": ENVIRONMENT,
    "suite": (str, NONE),
    "pictures": [PICTURE],
}


def read_results(path: Path) -> dict[str, Any]:
    """The results.json at `path`; OptionError where it cannot be read or is none, naming the place in it."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise OptionError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise OptionError(f"{path} is no JSON: {error}") from error
    version = data.get("schema") if isinstance(data, dict) else None
    if version != SCHEMA:
        raise OptionError(f"{path} is no results.json of this version: its schema is {version!r}, not {SCHEMA!r}")
    try:
        check(data, RESULTS)
    except ValueError as error:
        raise OptionError(f"{path} is no whole results.json: {error}") from error
    return data


def check(data: object, shape: Shape, where: str = "") -> None:
    """ValueError naming the place where `data` has not this shape."""
    if isinstance(shape, Each):
        check(data, dict, where)
        for name, value in data.items():  # type: ignore[attr-defined]
            check(value, shape.shape, f"{where}.{name}")
    elif isinstance(shape, dict):
        check(data, dict, where)
        for name, inner in shape.items():
            if name not in data:  # type: ignore[operator]
                raise ValueError(f"{where.lstrip('.') or 'the file'} has no {name!r}")
            check(data[name], inner, f"{where}.{name}")  # type: ignore[index]
    elif isinstance(shape, list):
        check(data, list, where)
        for index, value in enumerate(data):  # type: ignore[arg-type]
            check(value, shape[0], f"{where}[{index}]")
    elif not _is(data, shape if isinstance(shape, tuple) else (shape,)):
        kinds = " or ".join(kind.__name__ for kind in (shape if isinstance(shape, tuple) else (shape,)))
        raise ValueError(f"{where.lstrip('.') or 'the file'} must be {kinds}, is {data!r:.60}")


def _is(value: object, kinds: tuple[type, ...]) -> bool:
    if isinstance(value, bool):
        return bool in kinds
    return isinstance(value, kinds) or (float in kinds and isinstance(value, int))
