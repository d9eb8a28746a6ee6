#!/usr/bin/env bash
# Fills benchmarks/gpu/ (git-ignored, under 60 MB) with all that benchmarks/gpu.sh needs on a machine without a network: the
# packages for this Python on x86-64 Linux, the Vulkan loader, and four shots of the real scenes.
#
#     SOFTSHADOWS_SCENES=... bash benchmarks/gpu_fill.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scenes="${SOFTSHADOWS_SCENES:?SOFTSHADOWS_SCENES names the folder of the real scenes}"
python="${PYTHON:-python3}"
target=benchmarks/gpu
mkdir -p "$target/wheels" "$target/lib" "$target/scenes/shots"

# What rendering imports; truth and the command line stay behind.
packages=(wgpu rendercanvas cffi pycparser numpy pillow OpenEXR trimesh)
"$python" -m pip download --quiet --no-deps --only-binary=:all: --dest "$target/wheels" \
    $(for package in "${packages[@]}"; do grep -i "^$package==" requirements.lock; done)

if [[ -z "$(ls "$target/lib")" ]]; then
    folder="$(mktemp -d)"
    trap 'rm -rf "$folder"' EXIT
    (cd "$folder" && apt-get download --quiet libvulkan1 && dpkg -x libvulkan1_*.deb .)
    cp "$folder"/usr/lib/*/libvulkan.so.1 "$target/lib/"
fi

for shot in scorpion body classroom chair_line; do
    file="$scenes/shots/$shot.toml"
    model="$(sed -n 's/^scene = "\.\.\/\(.*\)".*/\1/p' "$file")"
    cp "$file" "$target/scenes/shots/"
    mkdir -p "$target/scenes/$(dirname "$model")"
    cp "$scenes/$model" "$target/scenes/$model"
done
chmod -R u+w "$target"
du -sh "$target"
