"""Pages of the documentation whose steps a test follows: their blocks of code name the files that they are."""

from __future__ import annotations

import re
from pathlib import Path

BLOCK = re.compile(r'^```(\w+) title="([^"]+)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> list[tuple[str, str, str]]:
    """A page's blocks: each one's language, the file that it is, and its text."""
    return [(language, file, text) for language, file, text in BLOCK.findall(page.read_text(encoding="utf-8"))]


def follow(page: Path, folder: Path) -> None:
    """Write the page's files under `folder`, a copy of the repository's."""
    for language, file, text in blocks(page):
        path = folder / file
        if language == "diff":
            path.write_text(patched(path.read_text(encoding="utf-8"), text), encoding="utf-8")
        else:
            assert not path.exists(), f"{file} is there already"
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")


def patched(text: str, changes: str) -> str:
    """`text` with the added lines of `changes` after the unchanged line that stands before them there."""
    lines = text.splitlines()
    place = -1
    for change in changes.splitlines():
        if change.startswith("+"):
            place += 1
            lines.insert(place, change[1:])
        else:
            assert lines.count(change[1:]) == 1, f"{change[1:]!r} does not stand once in the file"
            place = lines.index(change[1:])
    return "\n".join(lines) + "\n"
