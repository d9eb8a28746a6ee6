#!/usr/bin/env bash
# Writes requirements.lock: the newest versions that pyproject.toml allows, as installed in an empty environment.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

environment="$(mktemp -d)"
trap 'rm -rf "$environment"' EXIT

"${PYTHON:-python3}" -m venv "$environment"
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check '.[dev]'
{
    echo "# Versions known to work together; scripts/setup.sh installs these. Written by \`make lock\`."
    "$environment/bin/python" -m pip freeze --disable-pip-version-check --exclude softshadows
} > "$environment/requirements.lock"
cp "$environment/requirements.lock" requirements.lock
