"""The driver compiles nothing while light, camera and nodes move.

Mesa's software driver builds the value of a uniform scalar that a condition hangs on into the machine code, and
compiles anew for every value it meets: each new file in its shader cache is 40 to 500 ms of a frame. The count needs
that driver; another one keeps its cache elsewhere, which the test says by skipping.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import moved_frames
from softshadows.gpu.device import acquire

LABELS = [config.label for config in moved_frames.same_frames().CONFIGS]
SCRIPT = Path(moved_frames.__file__)

COMPILED_ANEW: dict[str, str] = {}
"""Labels that still compile kernels anew, with the kernel and the scalar."""

Counts = dict[str, dict[str, int]]


@pytest.fixture(scope="module")
def files_added(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Counts:
    """moved_frames.py's counts for the techniques whose tests run, by one process with a cache of its own."""
    if "llvmpipe" not in acquire().adapter.info["device"]:
        pytest.skip("this driver does not keep Mesa's shader cache")
    wanted = [item.callspec.params["label"] for item in request.session.items if item.path == request.path]
    environment = {name: value for name, value in os.environ.items() if name != "MESA_SHADER_CACHE_DISABLE"}
    environment["MESA_SHADER_CACHE_DIR"] = str(tmp_path_factory.mktemp("shaders"))
    command = [sys.executable, str(SCRIPT), *wanted]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    counts: Counts = json.loads(done.stdout)
    assert sum(added["first"] for added in counts.values()) > 0, "nothing is cached: the test could not fail"
    return counts


@pytest.mark.parametrize(
    "label",
    [
        pytest.param(label, marks=pytest.mark.xfail(strict=True, reason=COMPILED_ANEW[label]))
        if label in COMPILED_ANEW
        else label
        for label in LABELS
    ],
)
def test_moves_compile_nothing(label: str, files_added: Counts) -> None:
    moves = {move: added for move, added in files_added[label].items() if move != "first"}
    assert not any(moves.values()), f"files that moves added to the shader cache: {moves}"
