"""Imports go one way, from the top of LAYERS down, and no module imports itself by way of others."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = "softshadows"
SOURCE = Path(__file__).parents[2] / "src" / PACKAGE

LAYERS: tuple[tuple[str, ...], ...] = (
    ("__main__",),
    ("cli",),
    ("bench",),
    ("compare", "viewer", "export", "batch"),
    ("renderer",),
    ("techniques", "truth"),
    ("visibility",),
    ("passes",),
    ("lights",),
    ("gpu",),
    ("frame",),
    ("scene", "image"),
    ("errors",),
)
"""The parts of the package from top to bottom. Each may import those below it, and none of those beside it."""

APART = "metrics"
"""Imports nothing but errors; what stands above the renderer imports it."""

PUBLIC = "__init__"
"""Hands out names when they are asked for; what stands above the renderer imports it."""

MAY_USE_WGPU = {"gpu", "lights", "visibility", "passes", "techniques", "viewer", "export"}


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


def layer_of(part: str) -> int:
    return next(index for index, parts in enumerate(LAYERS) if part in parts)


def allowed(part: str, target: str) -> bool:
    if target in (part, "errors"):
        return True
    if part == PUBLIC:
        return layer_of(target) > layer_of("bench") if target != APART else True
    if part == APART:
        return False
    if target in (PUBLIC, APART):
        return layer_of(part) < layer_of("renderer")
    return layer_of(part) < layer_of(target)


def name_of(module: Path) -> str:
    return ".".join([PACKAGE, *module.relative_to(SOURCE).with_suffix("").parts]).removesuffix(".__init__")


def imported_at_once(module: Path) -> set[str]:
    """The names that a module imports when it is itself imported: not in functions, not for type checkers."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    statements = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    lines = {node.lineno for node in statements}
    return {name for line, name in imported_names(module) if line in lines}


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Chains of modules that end where they begin."""
    found: list[list[str]] = []
    done: set[str] = set()

    def visit(name: str, chain: list[str]) -> None:
        if name in chain:
            found.append([*chain[chain.index(name) :], name])
        elif name not in done:
            for target in sorted(imports.get(name, ())):
                visit(target, [*chain, name])
            done.add(name)

    for name in imports:
        visit(name, [])
    return found


def test_every_part_has_its_place() -> None:
    parts = {part_of(module) for module in modules()}
    known = {part for parts in LAYERS for part in parts}
    assert parts <= known | {PUBLIC, APART}, "a new part of the package: say in this file what it may import"


def test_there_is_no_circle() -> None:
    names = {name_of(module): module for module in modules()}

    def home(full: str) -> str:
        return next(one for one in (full, full.rpartition(".")[0], PACKAGE) if one in names)

    imports = {
        name: {home(full) for full in imported_at_once(module) if full.startswith(f"{PACKAGE}.")}
        for name, module in names.items()
    }
    assert circles(imports) == []
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == [["b", "c", "b"]]


def wrong_imports(module: Path) -> list[str]:
    """What a module must not import, by its part's place or because only the GPU's side knows wgpu."""
    part, where = part_of(module), module.relative_to(SOURCE).as_posix()
    wrong = []
    for line, name in imported_names(module):
        target = imported_part(name)
        is_upward = target is not None and not allowed(part, target)
        if is_upward or (name.split(".")[0] in {"wgpu", "rendercanvas"} and part not in MAY_USE_WGPU):
            wrong.append(f"{where}:{line}: {part} must not import {name}")
    return wrong


def test_imports_go_one_way_and_only_the_gpu_side_uses_wgpu() -> None:
    assert [wrong for module in modules() for wrong in wrong_imports(module)] == []


def test_the_rules_catch_a_wrong_import(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The reader of imports sees every way to write one, and the rules refuse what goes the wrong way."""
    for name in ("scene/model.py", "gpu/device.py", "gpu/upload.py", "renderer.py", "errors.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.setitem(globals(), "SOURCE", tmp_path)
    module = tmp_path / "gpu" / "device.py"
    module.write_text(
        "import softshadows.renderer\n"
        "from softshadows import renderer, errors\n"
        "from softshadows.renderer import render\n"
        "from ..renderer import render\n"
        "from .. import renderer\n"
        "from . import upload\n"
        "from .upload import Buffers\n"
        "def late():\n"
        "    from softshadows import render\n"
        "    import numpy, softshadows as ss\n"
    )
    targets = [imported_part(name) for _, name in imported_names(module)]
    assert targets == [
        "renderer", "renderer", "errors", "renderer", "renderer", "renderer",
        "gpu", "gpu", "__init__", None, "__init__",
    ]  # fmt: skip
    refused = {target for target in targets if target is not None and not allowed("gpu", target)}
    assert refused == {"renderer", "__init__"}
    assert len(wrong_imports(module)) == 7
    scene = tmp_path / "scene" / "model.py"
    scene.write_text("import wgpu\nfrom rendercanvas.auto import loop\n")
    assert len(wrong_imports(scene)) == 2
    assert not allowed("scene", "gpu")
    assert not allowed("metrics", "scene")
    assert not allowed("renderer", "compare")
    assert not allowed("compare", "viewer")
    assert not allowed("bench", "cli")
    assert not allowed("techniques", "truth")
    assert allowed("cli", "bench")
