"""scripts/setup.sh installs a driver only where no adapter works, and says what to do where it may not."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

FIND_ADAPTER = """
source scripts/setup.sh
has_adapter() {{ [[ -e "{adapter}" ]]; }}
apt_install() {{ echo "installs $1"; {install}; }}
find_adapter
"""


@pytest.mark.parametrize(
    ("works_before", "install", "status", "output"),
    [
        (True, "true", 0, ""),
        (False, "touch '{adapter}'", 0, "installs mesa-vulkan-drivers\n"),
        (False, "true", 1, "installs mesa-vulkan-drivers\n"),
        (False, "return 1", 1, "installs mesa-vulkan-drivers\n"),
    ],
    ids=["works already", "driver helps", "driver does not help", "may not install"],
)
def test_driver_is_installed_only_where_none_works(
    tmp_path: Path, works_before: bool, install: str, status: int, output: str
) -> None:
    adapter = tmp_path / "adapter"
    if works_before:
        adapter.touch()
    script = FIND_ADAPTER.format(adapter=adapter, install=install.format(adapter=adapter))
    done = subprocess.run(["bash", "-c", script], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (status, output)
    if status == 0:
        assert done.stderr == ""
    else:
        assert "found no Vulkan, Metal or Direct3D 12 adapter" in done.stderr
        assert "mesa-vulkan-drivers" in done.stderr


@pytest.mark.parametrize("python", ["/nonexistent/python3", "false"])
def test_a_missing_python_is_a_sentence(python: str) -> None:
    done = subprocess.run(
        ["bash", "-c", f"source scripts/setup.sh; PYTHON={python}; make_environment"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("softshadows needs Python 3.11 or newer")
