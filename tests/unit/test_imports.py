"""Imports go one way: cli, viewer, batch, report -> frame -> techniques, truth -> passes -> gpu -> scene.

`metrics` imports none of them. `errors` is everyone's; `display` and `save` serve the frame and what stands above it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = "softshadows"
SOURCE = Path(__file__).parents[2] / "src" / PACKAGE

MAY_IMPORT: dict[str, set[str]] = {
    "errors": set(),
    "metrics": {"errors"},
    "scene": {"errors"},
    "gpu": {"errors", "scene"},
    "passes": {"errors", "scene", "gpu"},
    "techniques": {"errors", "scene", "gpu", "passes"},
    "truth": {"errors", "scene", "gpu", "passes"},
    "display": {"errors"},
    "save": {"errors", "display"},
    "refinement": set(),
    "frame": {"errors", "scene", "gpu", "passes", "techniques", "truth", "display", "save", "refinement"},
}
"""What each part of the package may import besides itself. `TOP` may import all of it."""

TOP = {"report", "batch", "viewer", "cli", "cli_bench", "cli_parts", "__init__", "__main__"}
"""Nothing imports these, except that the command line, `CLI`, starts the others."""

CLI = ("cli", "cli_bench", "cli_parts", "__main__")

MAY_USE_WGPU = {"gpu", "passes", "techniques", "viewer"}


def modules() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def part_of(module: Path) -> str:
    """The first folder or file below the package: src/softshadows/gpu/device.py belongs to `gpu`."""
    return module.relative_to(SOURCE).parts[0].removesuffix(".py")


def imported_names(module: Path) -> Iterator[tuple[int, str]]:
    """Line and full dotted name of everything a module imports, inside functions and under TYPE_CHECKING too."""
    package = [PACKAGE, *module.relative_to(SOURCE).parts[:-1]]
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"), filename=str(module))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            yield from ((node.lineno, f"{origin}.{alias.name}") for alias in node.names)


def imported_part(name: str) -> str | None:
    """The part of softshadows that a dotted name is in: `__init__` for the package itself, None for other packages."""
    if name == PACKAGE:
        return "__init__"
    if not name.startswith(PACKAGE + "."):
        return None
    part = name.split(".")[1]
    return part if (SOURCE / part).is_dir() or (SOURCE / f"{part}.py").is_file() else "__init__"


def allowed(part: str, target: str) -> bool:
    if part == target:
        return True
    if part in MAY_IMPORT:
        return target in MAY_IMPORT[part]
    return target not in TOP or part in CLI or (target == "__init__" and part in TOP)


def test_every_part_has_its_place() -> None:
    parts = {part_of(module) for module in modules()}
    assert parts <= MAY_IMPORT.keys() | TOP, "a new part of the package: say in this file what it may import"


@pytest.mark.parametrize("module", modules(), ids=lambda path: path.relative_to(SOURCE).as_posix())
def test_imports_go_one_way(module: Path) -> None:
    part = part_of(module)
    wrong = [
        f"line {line}: {part} must not import {name}"
        for line, name in imported_names(module)
        if (target := imported_part(name)) is not None and not allowed(part, target)
    ]
    assert wrong == []


@pytest.mark.parametrize("module", modules(), ids=lambda path: path.relative_to(SOURCE).as_posix())
def test_only_the_gpu_side_uses_wgpu(module: Path) -> None:
    if part_of(module) not in MAY_USE_WGPU:
        names = {name.split(".")[0] for _, name in imported_names(module)}
        assert not names & {"wgpu", "rendercanvas"}


def test_the_rules_catch_a_wrong_import(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The reader of imports sees every way to write one, and the rules refuse what goes the wrong way."""
    for name in ("scene/model.py", "gpu/device.py", "gpu/upload.py", "frame.py", "errors.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.setitem(globals(), "SOURCE", tmp_path)
    module = tmp_path / "gpu" / "device.py"
    module.write_text(
        "import softshadows.frame\n"
        "from softshadows import frame, errors\n"
        "from softshadows.frame import render\n"
        "from ..frame import render\n"
        "from .. import frame\n"
        "from . import upload\n"
        "from .upload import Buffers\n"
        "def late():\n"
        "    from softshadows import render\n"
        "    import numpy, softshadows as ss\n"
    )
    targets = [imported_part(name) for _, name in imported_names(module)]
    assert targets == [
        "frame", "frame", "errors", "frame", "frame", "frame", "gpu", "gpu", "__init__", None, "__init__",
    ]  # fmt: skip
    refused = {target for target in targets if target is not None and not allowed("gpu", target)}
    assert refused == {"frame", "__init__"}
    assert not allowed("scene", "gpu")
    assert not allowed("metrics", "scene")
    assert not allowed("frame", "report")
    assert not allowed("report", "cli")
    assert allowed("cli", "report")
