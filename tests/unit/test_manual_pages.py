"""Every technique's docstring is its manual page: headings, a section map true to the shader, help for options."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

import pytest

from softshadows.techniques import TECHNIQUES

HEADINGS = ["Paper", "Section map", "Departures from the paper", "Use when", "Fails when", "Inputs", "Cost"]
TAG = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?(?: [^\]]+)?)\]")
SHADERS = Path(sys.modules["softshadows.techniques"].__file__ or "").parent.parent / "shaders"

techniques = pytest.mark.parametrize("name", list(TECHNIQUES))


def module_of(name: str) -> tuple[str, Path]:
    """The docstring and the folder of a technique's module."""
    module = sys.modules[TECHNIQUES[name].__module__]
    return inspect.getdoc(module) or "", Path(module.__file__ or "").parent


def section(manual: str, heading: str) -> str:
    """The text under a heading, up to the next line that is not indented."""
    match = re.search(rf"^{heading}\n((?:[ \t]+.*\n|\n)+)", manual + "\n", re.MULTILINE)
    return match[1] if match else ""


@techniques
def test_headings_are_there_in_order_and_none_is_empty(name: str) -> None:
    manual, _ = module_of(name)
    lines = manual.splitlines()
    assert lines[0].endswith("."), "the first line says what it is, in a sentence"
    found = [line for line in lines if line in HEADINGS]
    assert found == HEADINGS
    for heading in HEADINGS:
        assert section(manual, heading).strip(), f"nothing under {heading!r}"


@techniques
def test_one_word_names_a_technique(name: str) -> None:
    manual, folder = module_of(name)
    assert folder.name == name
    assert TECHNIQUES[name].__module__ == f"softshadows.techniques.{name}.{name}"
    assert manual


@techniques
def test_the_section_map_agrees_with_the_shader(name: str) -> None:
    """Tags of the map and of the technique's own shaders are the same; keys are the papers'; functions exist."""
    manual, folder = module_of(name)
    own = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.wgsl")}
    shared = {path.name: path.read_text(encoding="utf-8") for path in SHADERS.glob("*.wgsl")}
    section_map = section(manual, "Section map")
    if section_map.strip() == "none.":
        assert section(manual, "Paper").strip() == "none."
        return

    papers = set(re.findall(r"\[(\w+)\]", section(manual, "Paper")))
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
        text = option.metadata["help"]
        assert len(text) > 10, option.name
        assert not text.endswith("."), "help is a phrase, so that the legal values can follow it"
        meta = option.metadata
        assert meta["choices"] or meta["low"] > float("-inf"), f"{option.name} has no limits"
        legal = option.default in (*meta["choices"], meta["or_word"])
        assert legal or meta["low"] <= option.default <= meta["high"]
