"""Docstrings as Markdown: what both kinds of generated pages need."""

from __future__ import annotations

import re
import textwrap

DECISION = re.compile(r"(?:docs/decisions/)(\d{4})-([\w-]+)\.md")


def prose(text: str, decisions: str = "decisions/") -> str:
    """Docstring text as Markdown: signs outside of `code` stay signs, and mentions of decisions become links.

    `decisions` is the way from the page to their folder.
    """
    pieces = re.split(r"(`[^`]+`)", textwrap.dedent(text).strip("\n"))
    pieces[::2] = [_escaped(piece) for piece in pieces[::2]]
    linked = DECISION.sub(lambda m: f"[decision {int(m[1])}]({decisions}{m[1]}-{m[2]}.md)", "".join(pieces))
    return _lists_apart(linked)


def cell(text: str) -> str:
    """Markdown for a cell of a table, on one line."""
    return " ".join(text.split()).replace("|", "\\|")


def table(head: list[str], rows: list[list[str]], right: int = 0) -> str:
    """A Markdown table; its last `right` columns are numbers."""
    rule = ["---"] * (len(head) - right) + ["---:"] * right
    lines = [head, rule, *rows]
    return "\n".join("| " + " | ".join(map(cell, line)) + " |" for line in lines)


def _escaped(text: str) -> str:
    text = text.replace("&", "&amp;").replace("<", "&lt;")
    return re.sub(r"([*_])", r"\\\1", text) if not DECISION.search(text) else text


def _lists_apart(text: str) -> str:
    """Markdown wants an empty line before a list."""
    return re.sub(r"(?m)^((?!- | |$).+)\n(?=- )", r"\1\n\n", text)
