"""The steps of docs/adding_a_technique.md, followed to the letter in a copy of the package, give a technique."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from written_steps import blocks, follow

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "adding_a_technique.md"
NAME = "four_points"

RENDER = """
import numpy as np
import softshadows as ss
scene = ss.scenes.blocker()
errors = {}
for name in ("hard", "four_points", "uniform"):
    frame = ss.render(scene, technique=name, size=(96, 72), options={"grid": 9} if name == "uniform" else {})
    truth = ss.truth.visibility(scene, frame, samples=256)
    errors[name] = ss.metrics.compare(frame.visibility[0], truth[0], frame.surface & frame.facing[0]).penumbra_rmse
    if name == "four_points":
        levels = np.unique(frame.visibility)
        assert np.isin(levels, [0.0, 0.25, 0.5, 0.75, 1.0]).all() and len(levels) >= 4, levels
        assert frame.stats.shadow_maps == 4
# Across a straight penumbra the truth rises linearly from 0 to 1; four points give 0, 1/2 and 1 with steps at
# (1 -+ 1/sqrt(3)) / 2, hence an rms of 0.1495, and the hard shadow, one step in the middle, has 0.2887.
assert abs(errors["four_points"] - 0.1495) < 0.01 and abs(errors["hard"] - 0.2887) < 0.01, errors
assert errors["uniform"] < 0.3 * errors["four_points"], errors
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of a process that imports the copy in which the page's steps have been followed."""
    source = tmp_path_factory.mktemp("copy") / "src"
    shutil.copytree(ROOT / "src", source, ignore=shutil.ignore_patterns("__pycache__"))
    files = [Path(file).name for _, file, _ in blocks(PAGE)]
    assert files == ["__init__.py", f"{NAME}.py", f"{NAME}.wgsl", "__init__.py"]
    follow(PAGE, source.parent)
    return {**os.environ, "PYTHONPATH": str(source)}


def run(environment: dict[str, str], *arguments: str) -> str:
    """The output of Python with these arguments; fails with it where Python does."""
    done = subprocess.run([sys.executable, *arguments], env=environment, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_renders_what_it_says(environment: dict[str, str]) -> None:
    run(environment, "-c", RENDER)


def test_the_command_line_knows_it(environment: dict[str, str]) -> None:
    assert NAME in run(environment, "-m", "softshadows", "techniques")


def test_it_passes_the_tests_that_every_technique_has(environment: dict[str, str]) -> None:
    """Those of the manual, and of the contract the quick ones: an occluder, none, a light of no size."""
    quick = f"{NAME} and (section or heading or word or help or options or occluder or no_size or between_0_and_1)"
    files = ("tests/unit/test_manual_pages.py", "tests/contract/test_techniques.py")
    output = run(environment, "-m", "pytest", *files, "-q", "-k", quick, "-p", "no:cacheprovider")
    passed = re.search(r"(\d+) passed", output)
    assert passed, output
    assert int(passed[1]) >= 7, output


def test_the_page_is_formatted_as_the_code_is(tmp_path: Path) -> None:
    for language, file, text in blocks(PAGE):
        if language == "python" and text:
            path = tmp_path / Path(file).name
            path.write_text(text, encoding="utf-8")
            for check in (["format", "--check"], ["check"]):
                command = [sys.executable, "-m", "ruff", *check, "--config", str(ROOT / "pyproject.toml"), str(path)]
                done = subprocess.run(command, capture_output=True, text=True)
                assert done.returncode == 0, done.stdout + done.stderr
