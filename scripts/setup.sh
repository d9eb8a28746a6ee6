#!/usr/bin/env bash
# Makes this checkout ready to run: a virtual environment in .venv with known-good versions, and a driver to render with.
# Safe to run again: it installs only what is missing or out of date. `--no-driver` leaves out the driver.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

main() {
    make_environment
    if [[ "${1:-}" != "--no-driver" ]]; then
        make_runtime_dir
        find_adapter
    fi
}

# The environment is made anew when the interpreter, the packages asked for, their versions or this folder's place change.
make_environment() {
    local python wanted
    python="$(find_python)"
    wanted="$("$python" -VV; sed '/^\[tool\./,$d' pyproject.toml; cat requirements.lock; pwd)"
    if [[ -x .venv/bin/python && -f .venv/installed && "$(cat .venv/installed)" == "$wanted" ]]; then
        return
    fi
    "$python" -c 'import ensurepip' 2>/dev/null || apt_install python3-venv "the Python module venv" || true
    "$python" -c 'import ensurepip' 2>/dev/null || fail "$python has no module venv: install it (Debian and Ubuntu: apt-get install python3-venv) and run this again."

    echo "Installing Python packages into .venv ..."
    "$python" -m venv --clear .venv
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --constraint requirements.lock hatchling
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --constraint requirements.lock --no-build-isolation --editable '.[dev]'
    printf '%s\n' "$wanted" > .venv/installed
}

find_python() {
    local python
    for python in ${PYTHON:-python3 python3.13 python3.12 python3.11}; do
        if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            command -v "$python"
            return
        fi
    done
    fail "softshadows needs Python 3.11 or newer and found none; install one, or name it: make PYTHON=/path/to/python3"
}

# Mesa prints an error for every start without a runtime folder, on machines where nobody logs in.
make_runtime_dir() {
    if [[ -z "${XDG_RUNTIME_DIR:-}" || "$XDG_RUNTIME_DIR" == "$PWD/.venv/runtime" ]]; then
        export XDG_RUNTIME_DIR="$PWD/.venv/runtime"
        mkdir -p -m 700 "$XDG_RUNTIME_DIR"
    fi
}

find_adapter() {
    local problem="softshadows found no Vulkan, Metal or Direct3D 12 adapter to render with"
    local mesa="Mesa's software driver (package mesa-vulkan-drivers on Debian, Ubuntu and Fedora, vulkan-swrast on Arch)"
    if has_adapter; then return; fi
    apt_install mesa-vulkan-drivers "a software Vulkan driver" || fail "$problem. Install your GPU's driver, or $mesa."
    has_adapter || fail "$problem, although mesa-vulkan-drivers is installed. What the Vulkan loader finds: vulkaninfo --summary (package vulkan-tools)."
}

# OpenGL alone does not count: wgpu cannot run all of WebGPU on it. A software driver (adapter type CPU) does.
has_adapter() {
    local status=0
    .venv/bin/python - <<'PYTHON' || status=$?
import sys
import wgpu

backends = {adapter.info["backend_type"] for adapter in wgpu.gpu.enumerate_adapters_sync()}
sys.exit(0 if backends & {"Vulkan", "Metal", "D3D12"} else 3)
PYTHON
    if [[ "$status" != 0 && "$status" != 3 ]]; then
        fail "wgpu did not start (exit status $status): see the message above."
    fi
    return "$status"
}

# apt_install PACKAGE WHAT: false where this is not Debian or Ubuntu, or where we may not install.
apt_install() {
    local as_root=()
    grep -qsE '^(ID|ID_LIKE)=.*(debian|ubuntu)' /etc/os-release && command -v apt-get >/dev/null || return 1
    if [[ "$(id -u)" != 0 ]]; then
        sudo -n true 2>/dev/null || return 1
        as_root=(sudo -n)
    fi
    echo "Installing $2 ($1) ..."
    "${as_root[@]}" apt-get update -qq &&
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "$1" >/dev/null
}

fail() {
    echo "$1" >&2
    exit 1
}

if [[ "${BASH_SOURCE[0]}" == "$0" ]]; then
    main "$@"
fi
