#!/usr/bin/env bash
# Every technique on a real graphics card, in under eight minutes on a machine without a network, from benchmarks/gpu/ alone
# (gpu_fill.sh). Writes benchmarks/results/gpu-ADAPTER.json, after every shot what is known by then.
#
#     bash benchmarks/gpu.sh [FOLDER]         FOLDER for the JSON instead of benchmarks/results
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

filled=benchmarks/gpu
[[ -d $filled/wheels ]] || { echo "fill $filled first: bash benchmarks/gpu_fill.sh" >&2; exit 1; }
packages="$(mktemp -d)"
trap 'rm -rf "$packages"' EXIT
for wheel in "$filled"/wheels/*.whl; do
    python3 -m zipfile -e "$wheel" "$packages"
done
# What an installation would write: the package asks for its own version.
version="$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)"
mkdir "$packages/softshadows-$version.dist-info"
printf 'Metadata-Version: 2.1\nName: softshadows\nVersion: %s\n' "$version" > "$packages/softshadows-$version.dist-info/METADATA"
# A driver may be there without a loader, and without a place that a loader looks into.
if ! ldconfig -p | grep -q libvulkan.so.1; then
    export LD_LIBRARY_PATH="$PWD/$filled/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
fi
for file in /usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json; do
    [[ -f $file ]] && export VK_DRIVER_FILES="${VK_DRIVER_FILES:-$file}"
done
export PYTHONPATH="$PWD/src:$packages" PYTHONUNBUFFERED=1 SOFTSHADOWS_SCENES="$PWD/$filled/scenes"
python3 benchmarks/gpu.py "${1:-benchmarks/results}"
