"""Options of every technique: legal values, names, presets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.techniques import TECHNIQUES, make_technique
from softshadows.techniques.options import Number, OneOf, OneValueOf, Option, Table, values_of

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
    with pytest.raises(ss.OptionError, match="samples=3 has no option 'most'; samples=auto has"):
        make_technique("line_shadow_maps", {"samples": "3", "samples.most": "5"})


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
