"""The built wheel renders by itself, away from the source tree: a shader or module left out of it shows here."""

from __future__ import annotations

import json
import site
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

RENDER = """
import json, sys
import softshadows as ss

scene = ss.scenes.blocker()
frame = ss.render(scene, scene.camera, technique="uniform", size=(64, 48))
json.dump({
    "package": ss.__file__,
    "path": sys.path,
    "shape": frame.visibility.shape,
    "lowest": float(frame.visibility.min()),
    "highest": float(frame.visibility.max()),
}, open(sys.argv[1], "w"))
"""


@pytest.mark.wheel
def test_wheel_renders_in_an_empty_environment(tmp_path: Path) -> None:
    wheel = build_wheel(tmp_path / "dist")
    python = environment_with(wheel, tmp_path / "environment")
    answer_file = tmp_path / "answer.json"
    # -I: no PYTHONPATH, no current folder, no user packages.
    done = subprocess.run([python, "-I", "-c", RENDER, answer_file], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    answer = json.loads(answer_file.read_text())

    assert Path(answer["package"]).is_relative_to(tmp_path / "environment")
    assert not [entry for entry in answer["path"] if Path(entry).is_relative_to(ROOT / "src")]
    assert answer["shape"] == [1, 48, 64]
    assert answer["lowest"] < 0.1, "the blocker's umbra is in view"
    assert answer["highest"] == 1.0, "so is lit floor"


def build_wheel(folder: Path) -> Path:
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT)
    (wheel,) = folder.glob("*.whl")
    return wheel


def environment_with(wheel: Path, folder: Path) -> Path:
    """The Python of a new environment that holds the wheel alone and borrows this environment's other packages.

    A folder named in a .pth file joins the search path, but the .pth files inside it are not read: the editable
    install of the source tree, which is one, stays out.
    """
    venv.create(folder, with_pip=False, symlinks=True)
    python = folder / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-index", "--no-deps", wheel)
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "borrowed.pth").write_text("\n".join(site.getsitepackages()) + "\n")
    return python


def run(*command: object) -> None:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
