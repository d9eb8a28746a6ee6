"""The steps of docs/adding_a_light.md, followed to the letter in a copy of the package, give a kind of light."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from written_steps import blocks, follow

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "adding_a_light.md"
MOST_FILES = 5

CHECK = """
import numpy as np
import softshadows as ss

RADIUS, PLACE = 0.4, np.array([1.2, 2.6, 1.0])
scene = ss.scenes.figures()

def shown(radius, technique, **options):
    scene.lights = [ss.SphereLight(tuple(PLACE), (0.0, 0.5, 0.0), radius, (20.0, 20.0, 20.0))]
    return ss.render(scene, technique=technique, size=(96, 72), options=options)

# Samples, maps and rays know it: both are what the truth, which knows nothing of either, says.
soft, hard = shown(RADIUS, "uniform", grid=9), shown(RADIUS, "hard")
traced = shown(RADIUS, "uniform", grid=9, visibility="ray")
truth = ss.truth.visibility(scene, soft, samples=256)[0]
counted = soft.surface & soft.facing[0]
penumbra = counted & (truth > 0.05) & (truth < 0.95)
assert penumbra.sum() > 100, penumbra.sum()

def error(frame):
    return float(np.sqrt(np.mean((frame.visibility[0] - truth)[penumbra] ** 2)))

assert error(soft) < 0.05 and error(traced) < 0.05 and error(hard) > 0.2, (error(soft), error(traced), error(hard))

# A receiver faces it whose plane does not cut the sphere.
height = np.einsum("hwi,hwi->hw", soft.normal.astype(np.float64), PLACE - soft.position)
assert (soft.facing[0] == (soft.surface & (height > RADIUS))).all()
assert (soft.surface & ~soft.facing[0] & (height > 0.0)).any(), "it cuts some receiver's plane"

# Unshadowed, its light grows with its area, and is that of the point light that it shrinks to.
small, large = shown(0.1, "none").color, shown(0.2, "none").color
lit = soft.surface & (height > 0.4)
assert np.allclose(large[lit], 4.0 * small[lit], rtol=1e-4), "four times the area, four times the light"
intensity = 20.0 * np.pi * 0.1**2
scene.lights = [ss.PointLight(tuple(PLACE), (intensity, intensity, intensity))]
point = ss.render(scene, technique="none", size=(96, 72)).color
assert np.allclose(small[lit], point[lit], rtol=1e-4)

# It moves, and texts describe it.
moved = scene.lights[0].moved((0.0, 1.0, 0.0))
assert np.allclose(moved.center, PLACE + (0.0, 1.0, 0.0))
"""

LIGHT = "sphere:position=1.2,2.6,1:target=0,0.5,0:radius=0.4:radiance=20,20,20"


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of a process that imports the copy in which the page's steps have been followed."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))
    follow(PAGE, folder)
    return {**os.environ, "PYTHONPATH": str(folder / "src")}


def run(environment: dict[str, str], *arguments: str) -> str:
    """The output of Python with these arguments; fails with it where Python does."""
    done = subprocess.run([sys.executable, *arguments], env=environment, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_takes_few_files() -> None:
    assert len({file for _, file, _ in blocks(PAGE)}) <= MOST_FILES


def test_it_shines_and_casts_the_shadow_that_the_truth_says(environment: dict[str, str]) -> None:
    run(environment, "-c", CHECK)


def test_the_command_line_knows_it(environment: dict[str, str], tmp_path: Path) -> None:
    picture = tmp_path / "sphere.png"
    run(environment, "-m", "softshadows", "render", "blocker", "-t", "hard", "--light", LIGHT, "--size", "48x36",
        "-o", str(picture))  # fmt: skip
    assert picture.stat().st_size > 500


def test_the_changed_files_are_formatted_as_the_code_is(environment: dict[str, str]) -> None:
    source = Path(environment["PYTHONPATH"])
    files = [str(source.parent / file) for _, file, _ in blocks(PAGE) if file.endswith(".py")]
    for check in (["format", "--check"], ["check"]):
        run(environment, "-m", "ruff", *check, "--config", str(ROOT / "pyproject.toml"), *files)
