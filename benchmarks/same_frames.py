"""Do two versions of softshadows draw the same frames, bit for bit?

    python benchmarks/same_frames.py draw before/         with one version
    python benchmarks/same_frames.py draw after/          with the other
    python benchmarks/same_frames.py compare before after

Every technique and its main options draw the built-in scenes and, where SOFTSHADOWS_SCENES is set, three real shots,
each frame by a fresh renderer. Only the public interface is used, so that an older version can run the same file; an
option that changed its name or place is listed with all its spellings, of which the first that is accepted counts.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import softshadows as ss

BUILTIN = ("blocker", "figures", "fence", "leaves", "room", "atrium")
SHOTS = ("scorpion", "bike_near", "classroom_tube")
SIZE = (96, 72)


@dataclass(frozen=True)
class Config:
    """A technique with options, in all the spellings that versions know."""

    label: str
    technique: str
    spellings: tuple[Mapping[str, Any], ...] = ({},)

    def make(self) -> ss.techniques.Technique:
        for spelling in self.spellings[:-1]:
            try:
                return ss.techniques.make_technique(self.technique, spelling)
            except ss.OptionError:
                continue
        return ss.techniques.make_technique(self.technique, self.spellings[-1])


def config(label: str, technique: str, *spellings: Mapping[str, Any]) -> Config:
    return Config(label, technique, spellings or ({},))


CONFIGS = (
    config("none", "none"),
    config("hard", "hard"),
    config("pcf", "pcf"),
    config("pcf poisson", "pcf", {"pattern": "poisson", "kernel": 5, "spread": 1.5}),
    config("pcss", "pcss"),
    config("vsm", "vsm"),
    config("uniform", "uniform", {"grid": 5}),
    config("uniform equal", "uniform", {"grid": 4, "weights": "equal"}),
    config("uniform centres", "uniform", {"grid": 4, "layout": "centres"}, {"grid": 4, "weights": "midpoint"}),
    config("uniform rays", "uniform", {"grid": 5, "visibility": "ray"}),
    config("uniform hybrid", "uniform", {"grid": 5, "visibility": "hybrid"}),
    config(
        "uniform denoised",
        "uniform",
        {"grid": 4, "visibility": "ray", "offsets": "stratified", "denoise": True},
        {"grid": 4, "visibility": "ray", "visibility.offsets": "stratified", "visibility.denoise": True},
    ),
    config("adaptive", "adaptive", {"max_depth": 3}),
    config("adaptive rays", "adaptive", {"max_depth": 3, "visibility": "ray"}),
    config("adaptive hybrid", "adaptive", {"max_depth": 3, "visibility": "hybrid"}),
    config("adaptive cell", "adaptive", {"max_depth": 2, "filter": "cell"}),
    config(
        "adaptive pcf", "adaptive", {"max_depth": 2, "pcf": 3}, {"max_depth": 2, "filter": "pcf", "filter.texels": 3}
    ),
    config("adaptive global", "adaptive", {"max_depth": 3, "refinement": "global", "threshold": 3}),
    config("adaptive deferred", "adaptive", {"max_depth": 2, "evaluation": "deferred"}, {"max_depth": 2}),
    config("adaptive paper", "adaptive", {"max_depth": 2, "weights": "paper", "comparison_scale": 0.5}),
    config("bitmask", "bitmask"),
    config("bitmask rows 16", "bitmask", {"rows": 16}),
    config("bitmask preview", "bitmask", {"preset": "preview"}),
    config("variable_penumbra", "variable_penumbra"),
    config("variable_penumbra layers", "variable_penumbra", {"layers": 2}),
    config(
        "variable_penumbra fixed",
        "variable_penumbra",
        {"mask": "fixed", "kernel": 4, "self_shadowing": False},
        {"kernels": "fixed", "kernels.size": 4, "self_shadowing": False},
    ),
    config("variable_penumbra from_light", "variable_penumbra", {"kernels": "from_light", "layers": 2}),
    config("line_shadow_maps", "line_shadow_maps"),
    config("line_shadow_maps fixed", "line_shadow_maps", {"samples": 3}),
    config(
        "line_shadow_maps paper",
        "line_shadow_maps",
        {"samples": 2, "resolution": 500, "transition": "linear", "seen_by_both": "all", "gaps": "none"},
        {"preset": "paper"},
    ),
    config("line_shadow_maps ends", "line_shadow_maps", {"samples": 3, "shading": "ends"}),
    config("occluding_edges", "occluding_edges"),
    config(
        "occluding_edges paper",
        "occluding_edges",
        {"samples": 2, "penumbra": "texture", "rows": 2, "resolution": 800},
        {"preset": "paper"},
    ),
    config("occluding_edges ends", "occluding_edges", {"shading": "ends"}),
    config("penumbra_wedges", "penumbra_wedges"),
    config("penumbra_wedges additive", "penumbra_wedges", {"blending": "additive"}),
    config(
        "penumbra_wedges paper",
        "penumbra_wedges",
        {"rect": "paper", "quantise": True},
        {"preset": "paper"},
    ),
    config("penumbra_wedges union", "penumbra_wedges", {"blending": "union"}),
)


def under_a_line(scene: ss.Scene) -> None:
    """The scene's first light becomes a line along its own right axis."""
    light = scene.lights[0]
    right = light.axes[0] * max(light.half_extent[0], 0.5)
    start, end = tuple((light.center - right).tolist()), tuple((light.center + right).tolist())
    scene.lights = [ss.LineLight(start=start, end=end, radiance=(10.0, 10.0, 10.0))]


def views() -> Iterator[tuple[str, ss.Scene, ss.Camera]]:
    """Every scene under its own light, and under a line where it has another."""
    for name in BUILTIN:
        scene = ss.scenes.make(name)
        assert scene.camera is not None
        yield name, scene, scene.camera
        under_a_line(scene)
        yield f"{name}, line", scene, scene.camera
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if not folder:
        print("SOFTSHADOWS_SCENES is not set: real shots are left out", file=sys.stderr)
        return
    for name in SHOTS:
        shot = ss.load_shot(Path(folder) / "shots" / f"{name}.toml")
        yield name, shot.scene, shot.camera


def draw(folder: Path, scenes: str, labels: str) -> None:
    """One npz per view, holding visibility and colour by label; a refusal is held as its words."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, scene, camera in views():
        if scenes and name not in scenes.split("|"):
            continue
        images: dict[str, np.ndarray] = {}
        for one in CONFIGS:
            if labels and one.label not in labels.split("|"):
                continue
            try:
                frame = ss.render(scene, camera, technique=one.make(), size=SIZE)
            except ss.OptionError:
                continue  # a kind of light, or of material, that it does not do
            images[f"{one.label}/visibility"], images[f"{one.label}/color"] = frame.visibility, frame.color
        np.savez(folder / f"{name.replace(', ', '_')}.npz", **images)
        print(f"{name}: {len(images) // 2} frames", flush=True)


def compare(before: Path, after: Path) -> int:
    """Print every image that differs; the number of them."""
    differing = total = 0
    for path in sorted(after.glob("*.npz")):
        old, new = np.load(before / path.name), np.load(path)
        for key in sorted(set(old.files) | set(new.files)):
            if key not in old.files or key not in new.files:
                print(f"{path.stem} {key}: only {'before' if key in old.files else 'after'}")
                differing += key in old.files
                continue
            total += 1
            a, b = old[key], new[key]
            if a.shape != b.shape:
                print(f"{path.stem} {key}: shape {a.shape} -> {b.shape}")
                differing += 1
            elif a.tobytes() != b.tobytes():
                gap = np.abs(a.astype(np.float64) - b)
                print(f"{path.stem} {key}: {np.count_nonzero(gap)} of {gap.size} values, at most {gap.max():.3g}")
                differing += 1
    print(f"{total} images, {differing} differ")
    return differing


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    drawing = commands.add_parser("draw")
    drawing.add_argument("folder", type=Path)
    drawing.add_argument("--scenes", default="", help="names parted by |; default all")
    drawing.add_argument("--labels", default="", help="labels of techniques parted by |; default all")
    comparing = commands.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    arguments = parser.parse_args()
    if arguments.command == "draw":
        draw(arguments.folder, arguments.scenes, arguments.labels)
    elif compare(arguments.before, arguments.after):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
