"""The gallery: every script of `examples/`, with the picture that it makes."""

from __future__ import annotations

import ast
from pathlib import Path

from prose import prose

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
PICTURES = "images/examples"


def examples() -> list[Path]:
    """The scripts, in the order of their names."""
    return sorted(EXAMPLES.glob("*.py"))


def gallery_page() -> str:
    """The page, as Markdown."""
    parts = [
        "# Gallery",
        "Each picture is made by the script below it, from the folder `examples/`. "
        "Run one with `python examples/rectangle_light.py`; it writes into the folder that you are in.",
    ]
    for script in examples():
        parts += list(_entry(script))
    return "\n\n".join(parts) + "\n"


def _entry(script: Path) -> list[str]:
    source = script.read_text(encoding="utf-8")
    title, _, about = (ast.get_docstring(ast.parse(source)) or "").partition("\n")
    picture = next((ROOT / "docs" / PICTURES).glob(f"{script.stem}.*"))
    code = source.partition('"""\n')[2].lstrip()
    read = [file for file in sorted(EXAMPLES.glob("*.toml")) if file.name in source]
    return [
        f"## {title.rstrip('.')}",
        *([prose(about)] if about.strip() else []),
        f"![{title}]({PICTURES}/{picture.name})",
        f'```python title="examples/{script.name}"\n{code}```',
        *(f'```toml title="examples/{file.name}"\n{file.read_text(encoding="utf-8")}```' for file in read),
    ]
