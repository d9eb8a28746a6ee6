"""A technique's manual, taken apart: the docstring of its module has the same headings in every technique."""

from __future__ import annotations

import inspect
import re
import sys

from softshadows.techniques import Technique

HEADINGS = ("Paper", "Section map", "Departures from the paper", "Use when", "Fails when", "Inputs", "Cost")


def manual(cls: type[Technique]) -> tuple[str, dict[str, str]]:
    """What stands before the first heading of a technique's docstring, and the text under each heading."""
    text = inspect.getdoc(sys.modules[cls.__module__]) or ""
    pieces = re.split(rf"^({'|'.join(HEADINGS)})\n", text, flags=re.MULTILINE)
    return pieces[0].strip(), {
        heading: inspect.cleandoc("\n" + body) for heading, body in zip(pieces[1::2], pieces[2::2], strict=True)
    }


def summary(cls: type[Technique]) -> str:
    """The first sentence of a technique's manual."""
    first = manual(cls)[0].split("\n\n")[0]
    return re.split(r"(?<=[.!?])\s", " ".join(first.split()))[0]


def source(cls: type[Technique]) -> str:
    """Who published it: the first author and the year of each paper."""
    papers = re.findall(r"^\[[A-Za-z]+(\d{4})\]\s+([^\"]+?),\s+\"", manual(cls)[1]["Paper"], re.MULTILINE)
    names = [(re.split(r", | and ", authors), year) for year, authors in papers]
    return "; ".join(f"{first[0]}{' et al.' if len(first) > 1 else ''} {year}" for first, year in names)
