"""Every example runs, at a tiny size, and writes the picture that the gallery shows; all are short."""

from __future__ import annotations

import ast
import importlib.util
import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
TINY = {"size": (48, 36), "samples": 16, "count": 2, "frames": 2}
"""Arguments that make an example fast, passed where it has them."""

scripts = pytest.mark.parametrize("script", SCRIPTS, ids=[script.stem for script in SCRIPTS])


@scripts
def test_an_example_writes_its_picture(script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    main = load(script).main
    known = inspect.signature(main).parameters
    assert "size" in known
    main(**{name: value for name, value in TINY.items() if name in known})
    (picture,) = [path for path in tmp_path.glob(f"{script.stem}.*") if path.suffix in (".png", ".gif")]
    with Image.open(picture) as image:
        assert image.width >= TINY["size"][0]
        assert np.ptp(np.asarray(image.convert("L"))) > 50, "the picture is nearly blank"


@scripts
def test_an_example_is_short_and_says_what_it_shows(script: Path) -> None:
    source = script.read_text(encoding="utf-8")
    assert len(source.splitlines()) <= 40
    title, *rest = (ast.get_docstring(ast.parse(source)) or "").split("\n")
    assert title.endswith(".")
    assert any(rest), "a sentence or two after the title"


def load(script: Path) -> Any:
    """The example as a module."""
    spec = importlib.util.spec_from_file_location(script.stem, script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
