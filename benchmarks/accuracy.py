"""Error of `uniform` against ray-traced truth, and how much of it is light sampling: a table, and JSON.

    python benchmarks/accuracy.py blocker sphere_cube figures atrium room fence leaves
    SOFTSHADOWS_SCENES=... python benchmarks/accuracy.py scorpion body bunny bike --size 1024x768 --json figures.json

A name is a built-in scene or a shot in $SOFTSHADOWS_SCENES/shots. "lattice" is the same light samples with the same
weights, traced as rays: what is left of the error when every shadow map is perfect.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path

import numpy as np

import softshadows as ss
from softshadows.compare.environment import environment
from softshadows.lights.grid import grid_samples

COLUMNS = [
    ("rmse", "rmse", ".4f"),
    ("penumbra", "penumbra_rmse", ".4f"),
    ("bias", "bias", "+.4f"),
    ("leak", "leak_rate", ".1e"),
    ("false", "false_shadow_rate", ".1e"),
    ("lattice", "lattice_rmse", ".4f"),
    ("seconds", "seconds", ".1f"),
]


def open_scene(name: str) -> tuple[ss.Scene, ss.Camera]:
    """The scene and the camera of a built-in scene or a shot."""
    if name in ss.scenes.SCENES:
        scene = ss.scenes.make(name)
        assert scene.camera is not None
        return scene, scene.camera
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if folder is None:
        raise SystemExit(
            f"{name!r} is no built-in scene; set SOFTSHADOWS_SCENES to the folder that holds shots/{name}.toml"
        )
    shot = ss.load_shot(Path(folder) / "shots" / f"{name}.toml")
    return shot.scene, shot.camera


def traced_lattice(scene: ss.Scene, frame: ss.Frame, technique: ss.techniques.Uniform) -> np.ndarray:
    """(height, width) visibility of the first light from the technique's own samples, by rays."""
    light = frame.lights[0]
    points, weights = grid_samples(light, technique.grid, technique.weights)
    world = light.center + points @ light.axes[:2]
    total = np.zeros(frame.surface.shape)
    for part in np.array_split(np.arange(len(world)), max(len(world) // 16, 1)):
        seen = ss.truth.visibility_from_points(scene, frame, world[part], light=light)
        total += np.einsum("n,nhw->hw", weights[part], seen)
    return total / weights.sum()


def measure(name: str, size: tuple[int, int], technique: ss.techniques.Uniform, samples: int, lattice: bool) -> dict:
    """One row of the table."""
    scene, camera = open_scene(name)
    started = time.perf_counter()
    frame = ss.render(scene, camera, technique=technique, size=size)
    seconds = time.perf_counter() - started
    truth = ss.truth.visibility(scene, frame, samples=samples)[0]
    mask = frame.surface & frame.facing[0]
    comparison = ss.metrics.compare(frame.visibility[0], truth, mask=mask).as_dict()
    row = {"scene": name, "size": size, "weights": technique.weights, "seconds": seconds, **comparison}
    if lattice:
        difference = (traced_lattice(scene, frame, technique) - truth)[mask]
        row["lattice_rmse"] = float(np.sqrt(np.mean(difference**2)))
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="+")
    parser.add_argument("--size", default="512x384")
    parser.add_argument("--weights", default="trapezoid", help="trapezoid, equal, or both with a comma")
    parser.add_argument("--resolution", default="auto")
    parser.add_argument("--samples", type=int, default=1024, help="rays per pixel of the truth")
    parser.add_argument("--lattice", action="store_true", help="also trace the light samples")
    parser.add_argument("--json", type=Path, help="also write the rows here")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    rows = []
    print(f"{'scene':12} {'weights':10}" + "".join(f"{title:>10}" for title, _, _ in COLUMNS), flush=True)
    for name in arguments.names:
        for weights in arguments.weights.split(","):
            technique = ss.techniques.Uniform(weights=weights, resolution=arguments.resolution)
            row = measure(name, (width, height), technique, arguments.samples, arguments.lattice)
            rows.append(row)
            cells = (format(row.get(key, float("nan")), form) for _, key, form in COLUMNS)
            print(f"{name:12} {weights:10}" + "".join(f"{cell:>10}" for cell in cells), flush=True)
            if arguments.json:
                arguments.json.write_text(json.dumps({"environment": environment(), "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
