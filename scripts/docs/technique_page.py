"""A technique's page: its module's docstring, the declarations of its options, its pictures, its measured figures."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from manual import manual, summary
from prose import prose, table
from tables import technique_figures

from softshadows.techniques import TECHNIQUES, Technique
from softshadows.techniques.options import as_text

PICTURES = Path(__file__).parents[2] / "docs" / "images" / "techniques"
DECISIONS = "../decisions/"
LINE = "line:start=-1,3,1:end=1,3,1:radiance=20,20,20"
"""A light for techniques that cannot do that of the scene `figures`."""
ENTRY = re.compile(r"^\s*\[([^\]]+)\]\s+(.+?)\s+->\s+(\S+\.wgsl)\s+(.+)$", re.MULTILINE)


def technique_page(name: str) -> str:
    """The page of the technique called `name`."""
    cls = TECHNIQUES[name]
    intro, sections = manual(cls)
    captions = json.loads((PICTURES / "captions.json").read_text(encoding="utf-8"))[name]
    parts = [
        f"# {name}",
        prose(intro, DECISIONS),
        _picture(f"{name}.png", captions["picture"]),
        _how_to_use(cls),
        "## Use when",
        _sentence(sections["Use when"]),
        "## Fails when",
        _sentence(sections["Fails when"]),
        _picture(f"{name}-fails.png", captions["failure"]),
        "## Options",
        _options(cls),
        "## Figures",
        technique_figures(name),
        "## Inputs and cost",
        _sentence(sections["Inputs"]),
        _sentence(sections["Cost"]),
        "## Paper",
        _papers(sections["Paper"]),
        "## From the paper to the code",
        _section_map(sections["Section map"]),
        "## Departures from the paper",
        _sentence(sections["Departures from the paper"]),
    ]
    return "\n\n".join(parts) + "\n"


def techniques_page() -> str:
    """The list of all of them."""
    rows = [
        [f"[{name}]({name}.md)", prose(summary(cls)), ", ".join(sorted(cls.light_kinds))]
        for name, cls in TECHNIQUES.items()
    ]
    text = "Each page is made from the technique's own module: its docstring, its options, its measured figures."
    return f"# Techniques\n\n{text} [Which one to use](../choose.md) compares them.\n\n" + table(
        ["technique", "what it computes", "lights"], rows
    )


def _picture(file: str, caption: str) -> str:
    alone = caption.replace("`", "")
    return f"![{alone}](../images/techniques/{file})\n/// caption\n{prose(caption, DECISIONS)}\n///"


def _how_to_use(cls: type[Technique]) -> str:
    python = f"frame = ss.render(scene, camera, technique=ss.techniques.{cls.__name__}())"
    light = "" if "rect" in cls.light_kinds else f" --light {LINE}"
    return f"```python\n{python}\n```\n\n    softshadows render figures -t {cls.name}{light} -o picture.png"


def _sentence(text: str) -> str:
    """A section that goes on from its heading, as text that begins with a capital letter."""
    return prose(text[:1].upper() + text[1:], DECISIONS)


def _options(cls: type[Technique]) -> str:
    if not cls.options():
        return "None."
    rows = [
        [
            f"`{option.name}`" + (f"<br>of `{option.of}`" if option.of else ""),
            f"`{as_text(option.default)}`",
            option.legal.words,
            prose(option.help),
        ]
        for option in cls.options()
    ]
    written = table(["option", "default", "legal values", "what it does"], rows)
    if cls.presets:
        written += f"\n\nPresets, `-O preset={next(iter(cls.presets))}`; single options come on top of one:\n\n"
        written += table(["preset", "options"], [[f"`{name}`", _chosen(cls.presets[name])] for name in cls.presets])
    return written


def _chosen(options: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name}={as_text(value)}`" for name, value in options.items()) or "the defaults"


def _papers(text: str) -> str:
    if text == "none.":
        return "None."
    entries = re.split(r"^(?=\[)", text, flags=re.MULTILINE)
    return "\n".join("- " + prose(" ".join(entry.split()), DECISIONS) for entry in entries if entry.strip())


def _section_map(text: str) -> str:
    if text == "none.":
        return "None."
    rows = [[tag, prose(what, DECISIONS), f"`{file}`", f"`{where}`"] for tag, what, file, where in ENTRY.findall(text)]
    return table(["section", "what it says", "shader", "function"], rows)
