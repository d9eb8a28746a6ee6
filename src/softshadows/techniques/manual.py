"""A technique's manual page, which is its module's docstring, taken apart: for reports and documentation."""

from __future__ import annotations

import inspect
import re
import sys

from softshadows.techniques.base import Technique

HEADINGS = ("Paper", "Section map", "Departures from the paper", "Use when", "Fails when", "Inputs", "Cost")


def manual(technique: type[Technique]) -> str:
    """The whole page, as written."""
    return inspect.getdoc(sys.modules[technique.__module__]) or ""


def summary(technique: type[Technique]) -> str:
    """The page's first paragraph as one line: what the technique is."""
    return _one_line(manual(technique).partition("\n\n")[0])


def section(technique: type[Technique], heading: str) -> str:
    """The text under a heading, up to the next line that is not indented; empty where there is none."""
    match = re.search(rf"^{re.escape(heading)}\n((?:[ \t]+.*\n|\n)+)", manual(technique) + "\n", re.MULTILINE)
    return inspect.cleandoc(match[1]) if match else ""


def sentence(technique: type[Technique], heading: str) -> str:
    """A section of running text as one line."""
    return _one_line(section(technique, heading))


def _one_line(text: str) -> str:
    return " ".join(text.split())
