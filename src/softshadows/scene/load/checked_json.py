"""JSON read with suspicion: every value is checked where it is used, and errors carry its JSON pointer."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softshadows.errors import SceneError

MAX_INTEGER = 2**53
"""Largest integer that JSON readers agree on."""


@dataclass(frozen=True)
class Item:
    """A JSON object, with the file and the JSON pointer it came from."""

    data: dict[str, Any]
    file: Path
    pointer: str = ""

    def error(self, code: str, message: str, key: str | int | None = None) -> SceneError:
        """The SceneError for this object, or for its property `key`."""
        pointer = self.pointer if key is None else f"{self.pointer}/{key}"
        return SceneError(message, code=code, file=self.file, pointer=pointer or None)

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def _typed(self, key: str, kinds: type | tuple[type, ...], expected: str, *, required: bool) -> Any:
        if key not in self.data:
            if required:
                raise self.error("UNDEFINED_PROPERTY", f"property {key!r} is missing: expected {expected}", key)
            return None
        value = self.data[key]
        if not isinstance(value, kinds) or (isinstance(value, bool) and kinds is not bool):
            raise self.error("TYPE_MISMATCH", f"expected {expected}, got {_brief(value)}", key)
        return value

    def boolean(self, key: str, default: bool = False) -> bool:
        value = self._typed(key, bool, "true or false", required=False)
        return default if value is None else value

    def string(self, key: str, default: str | None = None, *, among: Sequence[str] | None = None) -> str:
        """The string `key`, one of `among` if given; required unless there is a default."""
        value: str = self._typed(key, str, "a string", required=default is None) or default or ""
        if among is not None and value not in among:
            raise self.error("VALUE_NOT_IN_LIST", f"expected one of {', '.join(among)}, got {_brief(value)}", key)
        return value

    def integer(self, key: str, default: int | None = None, *, low: int = 0, high: int = MAX_INTEGER) -> int:
        """The integer `key` in [low, high]; required unless there is a default. 3.0 counts as one."""
        value = self._typed(key, (int, float), "an integer", required=default is None)
        if value is None:
            return default  # type: ignore[return-value]
        if isinstance(value, float):
            if not value.is_integer():
                raise self.error("TYPE_MISMATCH", f"expected an integer, got {_brief(value)}", key)
            value = int(value)
        if not low <= value <= high:
            raise self.error("VALUE_NOT_IN_RANGE", f"expected an integer in {low}..{high}, got {_brief(value)}", key)
        return value

    def number(
        self, key: str, default: float | None = None, *, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """The finite number `key` in [low, high]; required unless there is a default."""
        value = self._typed(key, (int, float), "a number", required=default is None)
        return float(default) if value is None else self._finite(value, key, low, high)  # type: ignore[arg-type]

    def numbers(
        self,
        key: str,
        count: int,
        default: Sequence[float] | None = None,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> tuple[float, ...]:
        """The array `key` of exactly `count` finite numbers in [low, high]; required unless there is a default."""
        value = self._typed(key, list, f"an array of {count} numbers", required=default is None)
        if value is None:
            return tuple(default)  # type: ignore[arg-type]
        if len(value) != count:
            raise self.error("ARRAY_LENGTH_NOT_IN_LIST", f"expected {count} numbers, got {len(value)}", key)
        for element in value:
            if isinstance(element, bool) or not isinstance(element, (int, float)):
                raise self.error("ARRAY_TYPE_MISMATCH", f"expected numbers, got {_brief(element)}", key)
        return tuple(self._finite(element, key, low, high) for element in value)

    def _finite(self, value: int | float, key: str, low: float, high: float) -> float:
        try:
            result = float(value)
        except OverflowError:
            result = math.inf
        if not math.isfinite(result) or not low <= result <= high:
            interval = "a finite number" if math.isinf(low) and math.isinf(high) else f"a number in [{low:g}, {high:g}]"
            raise self.error("VALUE_NOT_IN_RANGE", f"expected {interval}, got {_brief(value)}", key)
        return result

    def index(self, key: str, count: int, what: str) -> int:
        """The required index `key` into an array of `count` elements called `what`."""
        value = self.integer(key)
        if value >= count:
            raise self.error("UNRESOLVED_REFERENCE", f"{what} {value} does not exist: there are {count}", key)
        return value

    def indices(self, key: str, count: int, what: str) -> list[int]:
        """The array `key` of indices into `count` elements called `what`; empty where absent."""
        values = self._typed(key, list, f"an array of {what} indices", required=False) or []
        holder = Item({str(i): value for i, value in enumerate(values)}, self.file, f"{self.pointer}/{key}")
        return [holder.index(position, count, what) for position in holder.data]

    def object(self, key: str) -> Item | None:
        """The object `key`, or None where absent."""
        value = self._typed(key, dict, "an object", required=False)
        return None if value is None else Item(value, self.file, f"{self.pointer}/{key}")

    def required_object(self, key: str) -> Item:
        value = self._typed(key, dict, "an object", required=True)
        return Item(value, self.file, f"{self.pointer}/{key}")

    def objects(self, key: str) -> list[Item]:
        """The array of objects `key`; empty where absent."""
        return list(self._objects(key))

    def _objects(self, key: str) -> Iterator[Item]:
        for position, value in enumerate(self._typed(key, list, "an array of objects", required=False) or []):
            pointer = f"{self.pointer}/{key}/{position}"
            if not isinstance(value, dict):
                raise SceneError(
                    f"expected an object, got {_brief(value)}", code="TYPE_MISMATCH", file=self.file, pointer=pointer
                )
            yield Item(value, self.file, pointer)

    def strings(self, key: str) -> list[str]:
        """The array of strings `key`; empty where absent."""
        values = self._typed(key, list, "an array of strings", required=False) or []
        for value in values:
            if not isinstance(value, str):
                raise self.error("ARRAY_TYPE_MISMATCH", f"expected strings, got {_brief(value)}", key)
        return values

    def extension(self, name: str) -> Item | None:
        """The object `extensions/<name>`, or None where absent."""
        extensions = self.object("extensions")
        return None if extensions is None else extensions.object(name)


def _brief(value: object) -> str:
    """`value` for an error message: short, whatever a hostile file put there."""
    if isinstance(value, (dict, list)):
        return f"an {'object' if isinstance(value, dict) else 'array'} of {len(value)}"
    if isinstance(value, int) and abs(value) > 10**30:
        return "an integer of more than 30 digits"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def parse_json(text: bytes, file: Path) -> Item:
    """The JSON object in `text`. Raises SceneError INVALID_JSON for what strict JSON forbids, and for repeated keys."""

    def refuse_constant(name: str) -> None:
        raise ValueError(f"{name} is not JSON")

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) != len(pairs):
            raise ValueError("an object names the same property twice")
        return result

    try:
        data = json.loads(text.decode("utf-8"), parse_constant=refuse_constant, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:  # UnicodeDecodeError and JSONDecodeError are ValueErrors
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise SceneError(f"not valid JSON: {reason}", code="INVALID_JSON", file=file) from None
    if not isinstance(data, dict):
        raise SceneError(f"expected a JSON object, got {_brief(data)}", code="TYPE_MISMATCH", file=file)
    return Item(data, file)
