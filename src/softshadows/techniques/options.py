"""Options: the fields of frozen dataclasses, declared once, and nested where they exclude each other.

    class Fixed(Choice):
        name: ClassVar[str] = "fixed"
        size: int = option(default=4, help="taps along the kernel's side", low=1, high=32)

    class VariablePenumbra(Technique):
        layers: int = option(default=1, help="layers of the map", choices=(1, 2))
        kernels: Bands | Fixed = choice(default=Bands(), converter=one_of(Bands, Fixed), help="how wide to filter")

A declaration gives validation, documentation, labels and the names by which everything else sets an option:
`VariablePenumbra(kernels=Fixed(size=7))`, `-O kernels=fixed -O kernels.size=7`, a shot's `[technique.kernels]` with
`type = "fixed"` and `size = 7`, and `make_technique("variable_penumbra", {"kernels": "fixed", "kernels.size": 7})`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar, Generic, Protocol, TypeVar, dataclass_transform

from softshadows.errors import OptionError

T = TypeVar("T")
S = TypeVar("S")


class Legal(Protocol):
    """The legal values of an option: `words` say which, and `parse` gives a value its type or raises ValueError."""

    @property
    def words(self) -> str: ...

    def parse(self, value: Any) -> Any: ...


@dataclass(frozen=True)
class OneValueOf:
    """One of some values, or the text of one."""

    values: tuple[Any, ...]

    @property
    def words(self) -> str:
        return "one of " + ", ".join(str(value) for value in self.values)

    def parse(self, value: Any) -> Any:
        for legal in self.values:
            same_kind = isinstance(value, bool) == isinstance(legal, bool)
            if (value == legal and same_kind) or value in (str(legal), str(legal).lower()):
                return legal
        raise ValueError(value)


@dataclass(frozen=True)
class Number:
    """A number of a kind, int or float, in [low, high], or its text; or the word `or_word`."""

    kind: type
    low: float = -math.inf
    high: float = math.inf
    or_word: str | None = None

    @property
    def words(self) -> str:
        noun = "a number" if self.kind is float else "a whole number"
        return f"{noun} {_interval(self.low, self.high)}" + (f", or {self.or_word}" if self.or_word else "")

    def parse(self, value: Any) -> Any:
        if self.or_word is not None and value == self.or_word:
            return value
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise ValueError(value)
        try:
            number = self.kind(value)
        except OverflowError:
            raise ValueError(value) from None
        if not self.low <= number <= self.high or (not isinstance(value, str) and number != value):
            raise ValueError(value)
        return number


@dataclass(frozen=True)
class Table:
    """A tuple of numbers, at least `fewest` and at most `most`, or their text with spaces between them."""

    number: Number
    fewest: int
    most: float

    @property
    def words(self) -> str:
        count = str(self.fewest) if self.most == self.fewest else f"{self.fewest} or more"
        whole = "whole " if self.number.kind is int else ""
        return (
            f"{count} {whole}numbers {_interval(self.number.low, self.number.high)}, as text with spaces between them"
        )

    def parse(self, value: Any) -> tuple[Any, ...]:
        if not isinstance(value, str | Sequence):
            raise ValueError(value)
        numbers = tuple(self.number.parse(item) for item in (value.split() if isinstance(value, str) else value))
        if not self.fewest <= len(numbers) <= self.most:
            raise ValueError(value)
        return numbers


@dataclass(frozen=True)
class OneOf(Generic[T]):
    """One of several `Choice` classes, by an instance or its name, which means its defaults; or a number."""

    classes: tuple[type[Choice], ...]
    number: Number | None = None

    @property
    def words(self) -> str:
        names = [cls.name for cls in self.classes]
        return f"{self.number.words}, or {names[0]}" if self.number else "one of " + ", ".join(names)

    def parse(self, value: Any) -> Any:
        for cls in self.classes:
            if isinstance(value, cls):
                return value
            if isinstance(value, str) and value == cls.name:
                return cls()
        if self.number is None:
            raise ValueError(value)
        return self.number.parse(value)

    def __call__(self, value: T | str) -> T:
        """For type checkers: what a constructor takes, and what the field then holds."""
        return self.parse(value)


def one_of(*classes: type[T]) -> OneOf[T]:
    """A choice between subclasses of Choice."""
    return OneOf(classes)  # type: ignore[arg-type]


def whole_number_or(cls: type[T], *, low: int, high: int) -> OneOf[int | T]:
    """A whole number in [low, high], or a Choice that finds one."""
    return OneOf((cls,), Number(int, low, high))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Option:
    """A declared option. `name` is what -O calls it, `kernels.size`; `of` names the choice that alone has it."""

    default: Any
    help: str
    legal: Legal
    name: str = ""
    of: str | None = None

    @property
    def classes(self) -> tuple[type[Choice], ...]:
        """The classes to choose from, where the option has options of its own."""
        return self.legal.classes if isinstance(self.legal, OneOf) else ()

    def parse(self, value: Any, owner: str) -> Any:
        """`value`, perhaps text from a command line, as the option's type, or OptionError."""
        try:
            return self.legal.parse(value)
        except ValueError:
            raise OptionError(f"{owner}: {self.name} must be {self.legal.words}; got {value!r}") from None


def option(
    *,
    default: Any,
    help: str,
    choices: Sequence[Any] = (),
    low: float = -math.inf,
    high: float = math.inf,
    or_word: str | None = None,
    entries: tuple[int, float] | None = None,
) -> Any:
    """An option's default, what it does, and its legal values.

    Either one of `choices`, or a number of the default's type in [low, high], or the word `or_word`. A default that is
    itself `or_word` means whole numbers. With `entries` a tuple of such numbers, at least and at most so many.
    """
    first = default[0] if entries else default
    legal: Legal = Number(float if isinstance(first, float) else int, low, high, or_word)
    if choices:
        legal = OneValueOf(tuple(choices))
    elif entries:
        legal = Table(Number(type(first), low, high), *entries)
    return field(default=default, metadata={"option": Option(default, help, legal)})


def choice(*, default: T, converter: Callable[[S], T], help: str) -> T:
    """An option that chooses between classes with options of their own; `converter` is `one_of` them."""
    assert isinstance(converter, OneOf)
    return field(default=default, metadata={"option": Option(default, help, converter)})


@dataclass_transform(frozen_default=True, field_specifiers=(option, choice))
class Options:
    """Base of dataclasses whose fields are options: frozen, and valid once made. OptionError says what is legal."""

    name: ClassVar[str]

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True)(cls)

    def __post_init__(self) -> None:
        for declared in own_options(type(self)):
            object.__setattr__(self, declared.name, declared.parse(getattr(self, declared.name), self.name))


class Choice(Options):
    """Base of the classes that an option chooses from. `name` is how text names one."""


def own_options(cls: type[Options]) -> tuple[Option, ...]:
    """The fields of one class, in order."""
    return tuple(replace(_declared(f), name=f.name) for f in _fields(cls))


def all_options(cls: type[Options]) -> Iterator[Option]:
    """The fields of a class, each followed by those of the classes that it chooses from."""
    for own in own_options(cls):
        yield own
        for chosen in own.classes:
            for nested in all_options(chosen):
                yield replace(nested, name=f"{own.name}.{nested.name}", of=chosen.name)


def values_of(options: Options) -> dict[str, Any]:
    """All options by name, a choice by its class's name."""
    return dict(_values(options, only_changes=False))


def changes_of(options: Options) -> dict[str, Any]:
    """The options that differ from their defaults, which make an equal object."""
    return dict(_values(options, only_changes=True))


def as_text(value: Any) -> str:
    """A value as a command line takes it."""
    if isinstance(value, Choice):
        return value.name
    return " ".join(f"{number:.9g}" for number in value) if isinstance(value, tuple) else str(value)


def flattened(given: Mapping[str, Any]) -> dict[str, Any]:
    """`{"kernels": {"type": "fixed", "size": 7}}` as `{"kernels": "fixed", "kernels.size": 7}`."""
    flat: dict[str, Any] = {}
    for name, value in given.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{key}" if key != "type" else name: nested for key, nested in value.items()}
        else:
            flat[name] = value
    return flat


def overlaid(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Flat options over others: `kernels=fixed` above also undoes what is said of `kernels` below."""
    kept = {name: value for name, value in below.items() if name.partition(".")[0] not in above}
    return {**kept, **above}


def build(cls: type[Any], given: Mapping[str, Any]) -> Any:
    """An object of a class of Options from flat options. OptionError for a name or a value that is not legal."""
    known = {declared.name: declared for declared in own_options(cls)}
    names = dict.fromkeys(declared.name for declared in all_options(cls))
    values: dict[str, Any] = {}
    for name, value in given.items():
        if name not in names:
            raise OptionError(f"{cls.name} has no option {name!r}; it has {', '.join(names) or 'none'}")
        if name in known:
            values[name] = known[name].parse(value, cls.name)
    for name, value in given.items():
        outer, dot, inner = name.partition(".")
        if dot:
            values[outer] = _with_nested(cls, known[outer], values.get(outer, known[outer].default), inner, value)
    return cls(**values)


def _with_nested(cls: type[Options], outer: Option, chosen: Any, inner: str, value: Any) -> Any:
    """The chosen object with one of its options set."""
    declared = {own.name: own for own in own_options(type(chosen))} if isinstance(chosen, Choice) else {}
    if inner not in declared:
        have = [other.name for other in outer.classes if inner in [own.name for own in own_options(other)]]
        said = chosen.name if isinstance(chosen, Choice) else chosen
        raise OptionError(
            f"{cls.name}: {outer.name}={said} has no option {inner!r}; {outer.name}={' and '.join(have)} has"
        )
    named = replace(declared[inner], name=f"{outer.name}.{inner}")
    return replace(chosen, **{inner: named.parse(value, cls.name)})


def _values(options: Options, *, only_changes: bool) -> Iterator[tuple[str, Any]]:
    for declared in own_options(type(options)):
        value = getattr(options, declared.name)
        is_choice = isinstance(value, Choice)
        is_changed = type(value) is not type(declared.default) if is_choice else value != declared.default
        if is_changed or not only_changes:
            yield declared.name, value.name if is_choice else value
        if is_choice:
            for name, nested in _values(value, only_changes=only_changes):
                yield f"{declared.name}.{name}", nested


def _declared(of: Field) -> Option:
    return of.metadata["option"]


def _fields(cls: type[Any]) -> tuple[Field, ...]:
    return fields(cls)


def _interval(low: float, high: float) -> str:
    return f"from {low:.9g} to {high:.9g}" if high < math.inf else f"of at least {low:.9g}"
