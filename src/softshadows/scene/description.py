"""Cameras and lights described in words: TOML tables of a shot, and one-line texts of the command line.

Both become a `Table`, and one set of functions turns tables into objects. The legal keys are the fields of the classes
themselves, so the two languages and the Python interface cannot drift apart.

    camera   position=4,2,5:target=0,1,0:vertical_fov=40
    light    rect:position=0,4,0:target=0,0,0:width=1:height=1:radiance=10,10,10
             line:start=-1,4,0:end=1,4,0:radiance=10,10,10

A semicolon separates as well as a colon (a shell needs quotes around it); `fov` is short for `vertical_fov`.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from softshadows.errors import SceneError
from softshadows.scene.camera import Camera
from softshadows.scene.lights import LIGHT_CLASSES, Light

VECTORS = {"position", "target", "up", "start", "end", "direction", "radiance", "intensity", "irradiance"}
SWITCHES = {"two_sided"}
LARGEST_SIZE = 16384
"""Largest width or height of a picture in pixels, the largest texture that any WebGPU adapter offers."""

T = TypeVar("T")


@dataclasses.dataclass(frozen=True)
class Table:
    """Named values and where they stand: `file` (or the option's name on the command line) and `pointer` inside it."""

    values: dict[str, Any]
    file: str | Path | None = None
    pointer: str = ""

    def at(self, key: str) -> str:
        return f"{self.pointer}.{key}" if self.pointer else key

    def fail(self, message: str, key: str | None = None, code: str = "VALUE_INVALID") -> NoReturn:
        """Raise the SceneError that says what is wrong at `key`, or at the table itself."""
        raise SceneError(message, code=code, file=self.file, pointer=(self.at(key) if key else self.pointer) or None)

    def allow_only(self, legal: Iterable[str], what: str) -> None:
        """SceneError for the first key that `what` does not know, with those it does."""
        legal = list(legal)
        for key in self.values:
            if key not in legal:
                self.fail(f"{what} has no key {key!r}; legal are {', '.join(legal)}", key, "KEY_UNKNOWN")

    def require(self, keys: Iterable[str], what: str) -> None:
        for key in keys:
            if key not in self.values:
                self.fail(f"{what} needs {key!r}", key, "KEY_MISSING")

    def subtable(self, key: str) -> Table:
        value = self.values[key]
        if not isinstance(value, dict):
            self.fail(f"must be a table, got {value!r}", key, "VALUE_NOT_TABLE")
        return Table(value, self.file, self.at(key))

    def subtables(self, key: str) -> list[Table]:
        value = self.values[key]
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.fail(f"must be an array of tables, written [[{key}]], got {value!r}", key, "VALUE_NOT_TABLE")
        return [Table(item, self.file, f"{self.at(key)}[{index}]") for index, item in enumerate(value)]

    def text(self, key: str) -> str:
        value = self.values[key]
        if not isinstance(value, str) or not value:
            self.fail(f"must be a text, got {value!r}", key, "VALUE_NOT_TEXT")
        return value

    def switch(self, key: str, default: bool = False) -> bool:
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            self.fail(f"must be true or false, got {value!r}", key, "VALUE_NOT_BOOLEAN")
        return value

    def number(self, key: str) -> float:
        return self._number(self.values[key], key, "a number")

    def vector(self, key: str) -> tuple[float, ...]:
        value = self.values[key]
        if not isinstance(value, list | tuple) or len(value) != 3:
            self.fail(f"must be three numbers, got {value!r}", key, "VALUE_NOT_VECTOR3")
        return tuple(self._number(component, key, "three numbers") for component in value)

    def _number(self, value: object, key: str, expected: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fail(f"must be {expected}, got {value!r}", key, "VALUE_NOT_NUMBER")
        try:
            return float(value)
        except OverflowError:
            self.fail("is too large a number", key, "VALUE_NOT_IN_RANGE")


def camera_from(table: Table) -> Camera:
    """The camera that `table` describes; SceneError for unknown or missing keys and for values the camera refuses."""
    return _build(Camera, table, "a camera")


def light_from(table: Table) -> Light:
    """The light that `table` describes by its `type` and that type's fields; SceneError as for cameras."""
    table.require(["type"], "a light")
    kind = table.text("type")
    if kind not in LIGHT_CLASSES:
        table.fail(
            f"no light has the type {kind!r}; legal are {', '.join(LIGHT_CLASSES)}", "type", "LIGHT_TYPE_UNKNOWN"
        )
    return _build(LIGHT_CLASSES[kind], table, f"a {kind} light", extra=["type"])


def size_from(table: Table, key: str = "size") -> tuple[int, int]:
    """(width, height) in pixels from a pair of whole numbers in 1..16384."""
    value = table.values[key]
    whole = isinstance(value, list | tuple) and all(isinstance(n, int) and not isinstance(n, bool) for n in value)
    if not whole or len(value) != 2 or not all(1 <= n <= LARGEST_SIZE for n in value):
        table.fail(
            f"must be [width, height] in pixels, each from 1 to {LARGEST_SIZE}, got {value!r}", key, "SIZE_INVALID"
        )
    return (value[0], value[1])


def camera_from_text(text: str) -> Camera:
    """A camera from a command-line text such as `position=4,2,5:target=0,1,0:vertical_fov=40`."""
    values = _pairs(text, "--camera")
    if "fov" in values:
        values["vertical_fov"] = values.pop("fov")
    return camera_from(Table(values, file="--camera"))


def light_from_text(text: str) -> Light:
    """A light from a command-line text such as `line:start=-1,4,0:end=1,4,0:radiance=10,10,10`."""
    kind, _, rest = text.partition(":")
    return light_from(Table({"type": kind.strip(), **_pairs(rest, "--light")}, file="--light"))


def size_from_text(text: str) -> tuple[int, int]:
    """(width, height) in pixels from a text such as `1024x768`."""
    match = re.fullmatch(r"\s*(\d{1,6})\s*[x×]\s*(\d{1,6})\s*", text)
    if match is None:
        raise SceneError(f"must look like 1024x768, got {text!r}", code="SIZE_INVALID", file="--size")
    return size_from(Table({"size": [int(part) for part in match.groups()]}, file="--size"))


def _build(cls: type[T], table: Table, what: str, extra: Iterable[str] = ()) -> T:
    fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    table.allow_only([*extra, *fields], what)
    required = [
        n for n, f in fields.items() if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    table.require(required, what)
    arguments = {key: _argument(table, key) for key in table.values if key in fields}
    try:
        return cls(**arguments)
    except SceneError as error:
        table.fail(error.message, error.pointer, error.code or "VALUE_INVALID")


def _argument(table: Table, key: str) -> object:
    if key in SWITCHES:
        return table.switch(key)
    return table.vector(key) if key in VECTORS else table.number(key)


def _pairs(text: str, option: str) -> dict[str, Any]:
    """`key=value` pairs of a command-line text; a value is a number, several with commas, true, false, or a word."""
    values: dict[str, Any] = {}
    for part in re.split(r"[:;]", text):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not key and not equals:
            continue
        if not equals:
            raise SceneError(f"expected key=value, got {part!r}", code="VALUE_INVALID", file=option)
        if key in values:
            raise SceneError("is given twice", code="KEY_DUPLICATE", file=option, pointer=key)
        parsed = [_scalar(item.strip()) for item in value.split(",")]
        values[key] = parsed if len(parsed) > 1 else parsed[0]
    return values


def _scalar(text: str) -> float | bool | str:
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text
