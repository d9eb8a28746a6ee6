"""What mkdocs adds to the written pages: pages made from the code, so that they say what the code says.

    techniques/<name>.md    technique_page.py    a technique's docstring, options, pictures and figures
    reference.md            reference_page.py    signatures and docstrings of the public names
    gallery.md              gallery_page.py      the examples and their pictures
    decisions               every page of docs/decisions, in the navigation
    <!-- table: NAME -->    tables.py            in a written page: a table of measured figures

mkdocs calls the functions whose names begin with `on_` (https://www.mkdocs.org/dev-guide/plugins/#events).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from gallery_page import gallery_page
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from reference_page import reference_page
from tables import TABLES
from technique_page import technique_page, techniques_page

from softshadows.techniques import TECHNIQUES

DOCS = Path(__file__).parents[2] / "docs"
PLACEHOLDER = re.compile(r"<!-- table: (\w+) -->")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Fill the navigation's sections Techniques and Decisions."""
    decisions = sorted((DOCS / "decisions").glob("[0-9]*.md"))
    sections = {
        "Techniques": ["techniques/index.md", *({name: f"techniques/{name}.md"} for name in TECHNIQUES)],
        "Decisions": ["decisions/README.md", *({_title(page): f"decisions/{page.name}"} for page in decisions)],
    }
    for entry in config.nav or []:
        for title in sections.keys() & (entry.keys() if isinstance(entry, dict) else ()):
            entry[title] = sections[title]
    return config


def _title(page: Path) -> str:
    """A page's first heading."""
    return next(line[2:] for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("# "))


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made from the code."""
    pages = {f"techniques/{name}.md": technique_page(name) for name in TECHNIQUES}
    pages |= {"techniques/index.md": techniques_page(), "reference.md": reference_page(), "gallery.md": gallery_page()}
    for path, content in pages.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put measured tables where a page asks for them."""
    return PLACEHOLDER.sub(lambda match: TABLES[match[1]](), markdown)
