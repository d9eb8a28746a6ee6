"""Every technique's docstring is its manual page: headings, a section map true to the shader, help for options."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from softshadows.techniques import TECHNIQUES
from softshadows.techniques.manual import HEADINGS, manual, section, sentence, summary
from softshadows.techniques.options import Number, as_text

TAG = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?(?: [^\]]+)?)\]")
SOURCE = Path(sys.modules["softshadows.techniques"].__file__ or "").parent.parent

techniques = pytest.mark.parametrize("name", list(TECHNIQUES))


def folder_of(name: str) -> Path:
    return Path(sys.modules[TECHNIQUES[name].__module__].__file__ or "").parent


@techniques
def test_headings_are_there_in_order_and_none_is_empty(name: str) -> None:
    lines = manual(TECHNIQUES[name]).splitlines()
    assert lines[0].endswith("."), "the first line says what it is, in a sentence"
    found = [line for line in lines if line in HEADINGS]
    assert found == list(HEADINGS)
    for heading in HEADINGS:
        assert section(TECHNIQUES[name], heading), f"nothing under {heading!r}"


@techniques
def test_one_word_names_a_technique(name: str) -> None:
    assert folder_of(name).name == name
    assert TECHNIQUES[name].__module__ == f"softshadows.techniques.{name}.{name}"


def test_a_page_is_taken_apart() -> None:
    """Sections end where the next begins, without their indentation; sentences lose their line breaks."""
    hard = TECHNIQUES["hard"]
    assert summary(hard) == manual(hard).splitlines()[0]
    assert section(hard, "Inputs") == "any light, taken as its centre."
    assert sentence(hard, "Fails when").startswith("the light has any size")
    assert "\n" not in sentence(hard, "Departures from the paper")
    assert section(hard, "Inputs when") == ""


@techniques
def test_the_section_map_agrees_with_the_shader(name: str) -> None:
    """Tags of the map and of the technique's own shaders are the same; keys are the papers'; functions exist."""
    technique = TECHNIQUES[name]
    own = {path.name: path.read_text(encoding="utf-8") for path in folder_of(name).glob("*.wgsl")}
    files = [path for path in SOURCE.rglob("*.wgsl") if "techniques" not in path.parts]
    shared = {path.name: path.read_text(encoding="utf-8") for path in files}
    section_map = section(technique, "Section map")
    if section_map.strip() == "none.":
        assert section(technique, "Paper") == "none."
        return

    papers = set(re.findall(r"\[(\w+)\]", section(technique, "Paper")))
    entries = re.findall(r"^\s*\[([^\]]+)\]\s+(.+?)\s+->\s+(\S+\.wgsl)\s+(.+)$", section_map, re.MULTILINE)
    assert len(entries) == len([line for line in section_map.splitlines() if line.strip()]), section_map
    assert {tag.split()[0] for tag, *_ in entries} == papers
    for tag, _, file, functions in entries:
        text = {**shared, **own}.get(file, "")
        assert text, f"[{tag}]: there is no {file}"
        for function in re.findall(r"(\w+)\(\)", functions):
            assert re.search(rf"^fn {function}\(", text, re.MULTILINE), f"[{tag}]: {file} has no {function}()"

    tags_in_shaders = {tag for text in own.values() for tag in TAG.findall(text)}
    tags_in_map = {tag for tag, _, file, _ in entries if file in own}
    assert tags_in_shaders == tags_in_map


@techniques
def test_options_say_what_they_do(name: str) -> None:
    for option in TECHNIQUES[name].options():
        assert len(option.help) > 10, option.name
        assert not option.help.endswith("."), "help is a phrase, so that the legal values can follow it"
        assert option.parse(option.default, name) == option.default
        assert option.parse(as_text(option.default), name) == option.default
        if isinstance(option.legal, Number):
            assert option.legal.low > float("-inf"), f"{option.name} has no limits"
        for chosen in option.classes:
            assert chosen.__doc__, f"{chosen.__name__} says what it is"
