"""What a user installs is complete: the wheel's files, its version, and the packages it asks for."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "softshadows"


@pytest.fixture(scope="module")
def wheel_files(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return set(zipfile.ZipFile(wheel).namelist())


def source_files(pattern: str) -> set[str]:
    return {path.relative_to(SOURCE.parent).as_posix() for path in SOURCE.rglob(pattern)}


@pytest.mark.parametrize("pattern", ["*.wgsl", "*.py", "py.typed"])
def test_wheel_has_every_file(wheel_files: set[str], pattern: str) -> None:
    """An ignore rule that matches a source folder, or a new kind of file, would leave files out in silence."""
    expected = source_files(pattern)
    assert expected
    assert expected - wheel_files == set()


def test_wheel_has_only_the_package_and_its_licence(wheel_files: set[str]) -> None:
    folders = {name.split("/")[0] for name in wheel_files}
    assert folders == {"softshadows", f"softshadows-{project()['version']}.dist-info"}
    assert f"softshadows-{project()['version']}.dist-info/licenses/LICENSE" in wheel_files


def test_package_is_typed() -> None:
    assert (SOURCE / "py.typed").is_file()


def test_version_is_the_changelog_s_newest() -> None:
    headings = re.findall(r"^## \[([^\]]+)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    released = [heading for heading in headings if heading != "Unreleased"]
    assert released[0] == project()["version"]


def test_every_imported_package_is_asked_for() -> None:
    """Imports at the top of a module need a dependency; imports inside a function may come from an extra."""
    required = names(project()["dependencies"])
    extras = project()["optional-dependencies"]
    optional = required.union(*(names(extras[extra]) for extra in extras if extra != "dev"))
    distributions = packages_distributions()
    for path in sorted(SOURCE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for statement in ast.walk(tree):
            allowed = required if statement in tree.body else optional
            for package in imported_packages(statement) - sys.stdlib_module_names - {"softshadows"}:
                found = {canonical(name) for name in distributions.get(package, [package])}
                assert found & allowed, f"{path.relative_to(ROOT)} imports {package}"


def test_lock_names_every_dependency_by_version_only() -> None:
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    pinned = [line for line in lines if line and not line.startswith("#")]
    assert [line for line in pinned if not re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!]+", line)] == []
    asked = names(project()["dependencies"]) | names(project()["optional-dependencies"]["dev"])
    assert asked - names(pinned) == set()


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def names(requirements: list[str]) -> set[str]:
    return {canonical(re.split(r"[^A-Za-z0-9._-]", requirement)[0]) for requirement in requirements}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def imported_packages(statement: ast.AST) -> set[str]:
    if isinstance(statement, ast.Import):
        return {alias.name.split(".")[0] for alias in statement.names}
    if isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
        return {statement.module.split(".")[0]}
    return set()
