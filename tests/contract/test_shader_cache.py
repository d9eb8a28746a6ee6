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

SCRIPT = Path(moved_frames.__file__)


def test_moves_compile_nothing(tmp_path: Path) -> None:
    """Every technique and its main options, by one process with a cache of its own."""
    if "llvmpipe" not in acquire().adapter.info["device"]:
        pytest.skip("this driver does not keep Mesa's shader cache")
    environment = {name: value for name, value in os.environ.items() if name != "MESA_SHADER_CACHE_DISABLE"}
    environment["MESA_SHADER_CACHE_DIR"] = str(tmp_path)
    labels = [config.label for config in moved_frames.same_frames().CONFIGS]
    command = [sys.executable, str(SCRIPT), *labels]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    added = json.loads(done.stdout)
    assert list(added) == labels
    assert sum(files.pop("first") for files in added.values()) > len(labels), "nothing is cached: this could not fail"
    assert not {label: files for label, files in added.items() if any(files.values())}
