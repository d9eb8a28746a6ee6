"""The command line: bad input is one sentence and exit code 2, help teaches, lists list. No GPU is used here."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from softshadows.cli.app import app
from softshadows.scene.builtin import SCENES
from softshadows.techniques import TECHNIQUES
from softshadows.techniques.options import as_text

SHOT = 'scene = "blocker"\nsize = [32, 24]\n[technique]\nname = "uniform"\ngrid = 3\n'

WRONG_LIGHT = """
[[lights]]
type = "rect"
position = [0, 1, 0]
target = [0, 0, 0]
width = -1
height = 1
radiance = [1, 1, 1]
[technique]"""

BAD_INPUT = {
    # arguments: what the sentence names
    "render": "SCENE",
    "render nowhere -o a.png": "built in are blocker",
    "render model.xyz -o a.png": ".glb",
    "render missing.glb -o a.png": "missing.glb",
    "render broken.glb -o a.png": "broken.glb",
    "render missing.toml -o a.png": "missing.toml",
    "render wrong.toml -o a.png": "lights[0].width",
    "render blocker -o a.jpg": ".png, .exr, .npz",
    "render blocker -o nowhere/a.png": "nowhere",
    "render blocker -t magic -o a.png": "uniform",
    "render blocker -t uniform -O gird=3 -o a.png": "grid",
    "render blocker -t uniform -O grid=zero -o a.png": "from 1 to",
    "render blocker -t uniform -O grid -o a.png": "NAME=VALUE",
    "render blocker -O grid=3 -o a.png": "-t",
    "render blocker --size 100 -o a.png": "1024x768",
    "render blocker --size 0x5 -o a.png": "from 1 to",
    "render blocker --light rect:position=0,1,0 -o a.png": "target",
    "render blocker --light sun -o a.png": "rect, disk, line",
    "render blocker --camera position=0,1,0:target=0,1,0 -o a.png": "--camera:target",
    "render blocker --on-missing ignore -o a.png": "warn",
    "render blocker --profile phone -o a.png": "portable",
    "compare blocker -t uniform,magic -o out": "magic",
    "compare blocker -t , -o out": "at least one technique",
    "compare blocker -t hard -O speed=3 -o out": "speed",
    "compare blocker --samples 0 -o out": "samples",
    "compare blocker -o file.txt": "file.txt",
    "bench nothing": "baselines",
    "bench baselines --json nowhere/out.json": "nowhere",
    "bench baselines --size big": "1024x768",
    "bench --size big baselines": "1024x768",
    "bench compare file.txt file.txt": "no JSON",
    "bench compare file.txt": "AFTER",
    "paint blocker": "paint",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a few files to be wrong about."""
    (tmp_path / "file.txt").write_text("")
    (tmp_path / "model.xyz").write_text("")
    (tmp_path / "broken.glb").write_bytes(b"glTF\x02\x00")
    (tmp_path / "shot.toml").write_text(SHOT)
    (tmp_path / "wrong.toml").write_text(SHOT.replace("[technique]", WRONG_LIGHT))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(arguments: str) -> Result:
    return CliRunner().invoke(app, arguments.split(), env={"COLUMNS": "200", "TERM": "dumb"})


@pytest.mark.parametrize("arguments", BAD_INPUT)
def test_bad_input_is_one_sentence_and_exit_code_2(folder: Path, arguments: str) -> None:
    result = run(arguments)
    assert result.exit_code == 2
    assert BAD_INPUT[arguments] in result.stderr
    assert "Traceback" not in result.output
    if result.stderr.startswith("softshadows:"):
        assert len(result.stderr.splitlines()) == 1
    assert not (folder / "a.png").exists()


@pytest.mark.parametrize("command", ["", "render", "compare", "bench", "techniques", "scenes", "info"])
def test_help_exists(command: str) -> None:
    result = run(f"{command} --help")
    assert result.exit_code == 0
    assert "Usage" in result.output


@pytest.mark.parametrize("command", ["render", "compare", "bench"])
def test_help_teaches_with_examples(command: str) -> None:
    assert f"softshadows {command} " in run(f"{command} --help").output.split("Usage", 1)[1].split("\n", 1)[1]


def test_scenes_are_listed() -> None:
    result = run("scenes")
    assert result.exit_code == 0
    assert all(name in result.output for name in SCENES)


def test_techniques_are_listed_with_their_options() -> None:
    result = run("techniques")
    assert result.exit_code == 0
    for name, cls in TECHNIQUES.items():
        assert name in result.output
        assert all(f"{option.name}={as_text(option.default)}" in result.output for option in cls.options())
        assert all(f"preset={preset}" in result.output for preset in cls.presets)


def test_help_names_every_suite() -> None:
    from softshadows.bench.suites import SUITES

    output = run("bench run --help").output
    assert all(name in output for name in SUITES)


def test_version() -> None:
    assert run("--version").output.startswith("softshadows 0")


def test_help_answers_quickly() -> None:
    """No numpy, no GPU, no scene for a help page: in processor time, as other programs run too."""
    before = os.times()
    subprocess.run([sys.executable, "-c", "import softshadows.cli.app"], check=True)
    after = os.times()
    assert after.children_user - before.children_user + after.children_system - before.children_system < 0.5


def test_the_command_line_imports_nothing_heavy() -> None:
    program = (
        "import sys, softshadows.cli.app; "
        "print([m for m in ('trimesh', 'embreex', 'OpenEXR', 'PIL') if m in sys.modules])"
    )
    output = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    assert output.strip() == "[]"
