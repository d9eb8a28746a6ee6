"""Options of every technique: legal values, names, presets; and each does something, whatever the others say."""

from __future__ import annotations

import functools
import itertools
from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.scene.builtin.shapes import mesh, sphere
from softshadows.techniques import TECHNIQUES, Technique, make_technique
from softshadows.techniques.options import Number, OneOf, OneValueOf, Option, Table, as_text, values_of

MOST_OPTIONS = 55
PAPERS = ("adaptive", "variable_penumbra", "line_shadow_maps", "occluding_edges", "penumbra_wedges")
ALL = [(name, option) for name, cls in TECHNIQUES.items() for option in cls.options()]

all_options = pytest.mark.parametrize(
    ("name", "option"), ALL, ids=[f"{name}-{option.of or ''}-{option.name}" for name, option in ALL]
)


def chosen_for(option: Option) -> dict[str, Any]:
    """What has to be chosen so that the option is there."""
    return {option.name.partition(".")[0]: option.of} if option.of else {}


def ends_of(option: Option) -> list[Any]:
    """The lowest and highest values, and all that have a name."""
    legal = option.legal
    if isinstance(legal, OneValueOf):
        return list(legal.values)
    if isinstance(legal, OneOf):
        numbers = [legal.number.low, legal.number.high] if legal.number else []
        return [*(cls.name for cls in legal.classes), *numbers]
    if isinstance(legal, Table):
        return [(legal.number.kind(end),) * legal.fewest for end in (legal.number.low, legal.number.high)]
    assert isinstance(legal, Number)
    return [legal.kind(end) for end in (legal.low, legal.high)] + ([legal.or_word] if legal.or_word else [])


def test_there_are_few() -> None:
    assert len(ALL) <= MOST_OPTIONS


@pytest.mark.parametrize(
    ("name", "option", "value"),
    [(name, option, value) for name, option in ALL for value in ends_of(option)],
    ids=lambda value: value.name if isinstance(value, Option) else str(value),
)
def test_every_option_at_its_ends(name: str, option: Option, value: Any) -> None:
    """An image, or a DeviceError that says what to lower where the value asks for too much memory."""
    technique = stage.cheap(name, **{"resolution": 64, "grid": 3, **chosen_for(option), option.name: value})
    try:
        frame = stage.render(stage.standard_scene(stage.light_for(name)), technique, (16, 12))
    except ss.DeviceError as error:
        refusal = str(error)
    else:
        stage.check_visibility(frame)
        return
    assert "ower" in refusal
    assert option.name == "resolution", "only the largest maps may be refused"
    assert value in (8192, 16384)


@all_options
def test_illegal_values_are_answered_with_the_legal_ones(name: str, option: Option) -> None:
    legal = option.legal
    illegal: list[Any] = ["nonsense", None, [], float("nan"), {"nonsense": 1}]
    illegal += [] if isinstance(legal, OneValueOf) and True in legal.values else [True]
    number = legal.number if isinstance(legal, OneOf | Table) else legal
    if isinstance(number, Number):
        illegal += [end for end in (number.low - 1.0, number.high + 1.0) if np.isfinite(end)]
    for value in illegal:
        with pytest.raises(ss.OptionError, match=option.name) as refused:
            make_technique(name, {**chosen_for(option), option.name: value})
        if not isinstance(value, dict):
            assert legal.words in str(refused.value)


@pytest.mark.parametrize("name", TECHNIQUES)
def test_an_unknown_option_is_answered_with_those_there_are(name: str) -> None:
    with pytest.raises(ss.OptionError) as unknown:
        make_technique(name, {"colour": 3})
    assert all(option.name in str(unknown.value) for option in TECHNIQUES[name].options())


def test_an_option_of_another_choice_is_answered_with_the_choice_that_has_it() -> None:
    with pytest.raises(ss.OptionError, match="kernels=bands has no option 'taps'; kernels=from_light has"):
        make_technique("variable_penumbra", {"kernels.taps": 9})
    with pytest.raises(ss.OptionError, match="filter=none has no option 'texels'; filter=pcf has"):
        make_technique("adaptive", {"filter": "none", "filter.texels": "3"})


def test_all_ways_to_set_a_nested_option_make_the_same_technique() -> None:
    made = ss.techniques.VariablePenumbra(kernels=ss.techniques.FromLight(taps=25), layers=2)
    flat = {"kernels": "from_light", "kernels.taps": "25", "layers": "2"}
    assert make_technique("variable_penumbra", flat) == made
    assert make_technique("variable_penumbra", {"kernels": {"type": "from_light", "taps": 25}, "layers": 2}) == made
    assert make_technique("variable_penumbra", {"kernels": "from_light"}) == ss.techniques.VariablePenumbra(
        kernels=ss.techniques.FromLight()
    )
    assert make_technique("variable_penumbra", values_of(made)) == made


@pytest.mark.parametrize("name", PAPERS)
def test_every_paper_has_a_preset(name: str) -> None:
    cls = TECHNIQUES[name]
    assert cls.preset("paper") == make_technique(name, {"preset": "paper"}) != cls()


@pytest.mark.parametrize("name", TECHNIQUES)
def test_presets_can_be_made_and_an_unknown_one_is_answered_with_those_there_are(name: str) -> None:
    cls = TECHNIQUES[name]
    for preset in cls.presets:
        assert isinstance(cls.preset(preset), cls)
    with pytest.raises(ss.OptionError, match=", ".join(cls.presets) or "none"):
        make_technique(name, {"preset": "the best"})


def test_single_options_come_on_top_of_a_preset() -> None:
    seven = make_technique("variable_penumbra", {"kernels.size": 5, "preset": "7x7"})
    assert seven == ss.techniques.VariablePenumbra(kernels=ss.techniques.Fixed(size=5))
    again = make_technique("variable_penumbra", {"kernels": "fixed", "preset": "7x7"})
    assert again == ss.techniques.VariablePenumbra(kernels=ss.techniques.Fixed()), "a choice means its defaults"


# -- Every option, and every pair of them, changes something -----------------------------------------------------------

NODES = [
    stage.floor(),
    stage.card(-0.9, 0.2, -0.7, 0.45, 1.1),
    stage.box((0.55, 0.0, -0.35), (1.2, 0.8, 0.5)),
    stage.box((-0.5, 0.4, -0.3), (-0.1, 0.9, 0.3)),
    stage.moved(ss.Node(mesh(sphere(100, 0.5), stage.MATT)), (0.1, 0.6, 0.6)),
]
"""Occluders over occluders, contact, a solid that shades itself, and a round one."""
RECT = ss.RectLight((0.6, 3.0, 0.4), (0.0, 0.0, 0.0), 1.2, 0.8, stage.WHITE)
LINE = ss.LineLight((-0.6, 3.0, 0.3), (0.8, 3.0, 0.5), stage.WHITE)
SIZE = (64, 48)
BASE = {"resolution": 96, "grid": 4, "max_depth": 3}
"""Options that make frames cheap, where a technique has them."""
OTHER_NUMBERS = {
    "resolution": 64,
    "kernel": 3,
    "spread": 2.5,
    "light_bleed_reduction": 0.0,
    "blocker_samples": 9,
    "filter_samples": 9,
    "grid": 5,
    "max_depth": 2,
    "threshold": 50,
    "samples": 2,
    "kernels.sizes": (2, 6, 8),
    "kernels.edges": (0.1, 0.3, 0.6),
    "kernels.size": 2,
    "kernels.taps": 9,
    "shading.influence": (0.4, 0.9),
}
"""For options that are numbers: one that is not the default, and far enough from it to show in so small a picture."""

Outcome = tuple[bytes, int, float, tuple[str, ...]]


@functools.cache
def outcome(technique: Technique) -> Outcome:
    """A frame's visibility and what its statistics say of it."""
    scene = ss.Scene(NODES, [RECT if "rect" in technique.light_kinds else LINE], stage.CAMERA)
    frame = ss.render(scene, technique=technique, size=SIZE)
    stats = frame.stats
    return frame.visibility.tobytes(), stats.shadow_maps, stats.lookups_per_pixel, tuple(stats.warnings)


def other_values(option: Option) -> list[Any]:
    """All that have a name, and a number, but the default."""
    legal, default = option.legal, as_text(option.default)
    if isinstance(legal, OneValueOf):
        return [value for value in legal.values if as_text(value) != default]
    if isinstance(legal, OneOf):
        numbers = [OTHER_NUMBERS[option.name]] if legal.number else []
        return [*(cls.name for cls in legal.classes if cls.name != default), *numbers]
    return [OTHER_NUMBERS[option.name]]


def made(name: str, *sets: dict[str, Any]) -> Technique | None:
    """The technique with these options over BASE, the later ones over the earlier; None where it is refused."""
    known = {option.name for option in TECHNIQUES[name].options()}
    options = {key: value for key, value in BASE.items() if key in known}
    for each in sets:
        options |= each
    if options.get("visibility") == "ray" and options["resolution"] == BASE["resolution"]:
        del options["resolution"]  # rays refuse it
    try:
        return make_technique(name, options)
    except ss.OptionError:
        return None


def changes(before: Technique | None, after: Technique | None) -> bool:
    """Is anything else seen or said, or one of them refused?"""
    return before is None or after is None or outcome(before) != outcome(after)


@pytest.mark.parametrize("name", TECHNIQUES)
def test_every_option_changes_something(name: str) -> None:
    dead = [
        f"{option.name}={value} {chosen_for(option)}"
        for option in TECHNIQUES[name].options()
        for value in other_values(option)
        if not changes(made(name, chosen_for(option)), made(name, chosen_for(option), {option.name: value}))
    ]
    assert not dead


@pytest.mark.parametrize("name", TECHNIQUES)
def test_every_option_changes_something_whatever_another_says(name: str) -> None:
    """Else the other one excludes it, and should have it nested in its choices or refuse it."""
    dead = []
    for first, second in itertools.combinations(TECHNIQUES[name].options(), 2):
        chosen = chosen_for(first) | chosen_for(second)
        if chosen != chosen_for(second) | chosen_for(first) or {first.name, second.name} & set(chosen):
            continue  # options of different choices, or a choice and its own option
        for one, other in itertools.product(other_values(first), other_values(second)):
            both = made(name, chosen, {first.name: one, second.name: other})
            for alone, dropped in ((first.name, second), (second.name, first)):
                single = made(name, chosen, {alone: one if alone == first.name else other})
                if not changes(single, both):
                    dead.append(f"{dropped.name} with {first.name}={one} {second.name}={other}")
    assert not dead
