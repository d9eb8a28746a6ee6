"""The field's words, in code, comments, documentation and messages: old home-made ones stay away."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]

OLD_WORDS: dict[str, str] = {
    r"closeness": "inverse depth",
    r"\bSight\b|\bsight_|_sight\b": "map sample, project into map",
    r"\bopen_segments\b": "trace_visibility, unoccluded",
    r"(?<![\w`])(?:packet|segments?|start)\.until\b|\bgoes_until\b": "t_max",
    r"\bbeside_[abc]\b": "edge functions",
    r"known_by_map|known_by_nothing|\bmap_answer": "classify by map; visibility class",
    r"\bcs_(?:judge|stay|close_up)\b|\bstay_before\b": "collapse, compact, number nodes",
    r"\bsum_up_to\b|\bsum_of_all\b|\bsums? up to\b": "inclusive scan",
    r"\bway goes on past\b": "escape index",
    r"\bremembered\(|\bthe remembered\b": "visibility bits",
    r"\bsub[-_]positions?\b|\bblock_places\b|\bplaces_of\b": "jitter, stratification",
    r"[Yy]ardstick|\bheld against\b": "reference, compared with",
    r"\bask(?:s|ed|ing)? (?:rays|maps)\b": "traces rays, looks up maps",
    r"\bdrawn anew\b|\bdraws? all anew\b|\bkeeps?_maps\b|\bkept maps?\b|\bmaps (?:are )?kept\b": "redrawn; cached",
    r"\btakes? (?:its|their) turns?\b|\bin turns\b|\btakes? turns\b|\brender_in_turns\b": "is selected; interleaved",
    r"\bnearer the truth\b": "more accurate",
    r'(?m)^\s*"""Of ': "say what it is, with its unit",
}
"""A pattern of what is not written, and what is."""

HISTORY = {"CHANGELOG.md"}
"""Files that tell what was."""


def texts() -> Iterator[tuple[str, str]]:
    files = [*ROOT.glob("*.md")]
    for folder in ("src", "tests", "docs", "examples", "scripts", "benchmarks"):
        files += [path for path in (ROOT / folder).rglob("*") if path.suffix in {".py", ".wgsl", ".md", ".toml"}]
    for path in sorted(files):
        if path != Path(__file__) and path.name not in HISTORY:
            yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def offenders(name: str, text: str) -> list[str]:
    found = []
    for pattern, word in OLD_WORDS.items():
        for match in re.finditer(pattern, text):
            line = text.count("\n", 0, match.start()) + 1
            found.append(f"{name}:{line}: {match[0]!r}; write: {word}")
    return found


def test_old_words_are_not_used() -> None:
    found = [each for name, text in texts() for each in offenders(name, text)]
    assert not found, "\n".join(found)


def test_the_check_of_words_can_fail() -> None:
    assert offenders("a.wgsl", "let closeness = sight_through(packet.until);\n// takes its turn") == [
        "a.wgsl:1: 'closeness'; write: inverse depth",
        "a.wgsl:1: 'sight_'; write: map sample, project into map",
        "a.wgsl:1: 'packet.until'; write: t_max",
        "a.wgsl:2: 'takes its turn'; write: is selected; interleaved",
    ]
