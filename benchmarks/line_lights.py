"""Line lights: error against rays of soft shadow maps and of plain sampling, with 512 rays and at any size.

    python benchmarks/line_lights.py chair_line bike_line classroom_tube figures fence sphere_cube atrium

A name is a shot in SOFTSHADOWS_SCENES, or a built-in scene, whose first light becomes a line along its right axis.
Times, and more techniques, are what `softshadows bench linear` measures.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import softshadows as ss
from softshadows.bench.suites.linear import under_a_line
from softshadows.techniques import LineShadowMaps, Technique, Uniform

PAPER = {"samples": 2, "transition": "linear", "between": "ends"}
COMPARED: dict[str, Technique] = {
    "paper": LineShadowMaps(**PAPER),
    "two samples": LineShadowMaps(samples=2),
    "five samples": LineShadowMaps(samples=5),
    "auto": LineShadowMaps(),
    **{f"uniform {grid}": Uniform(grid=grid) for grid in (5, 9, 17)},
}


def load(name: str) -> tuple[ss.Scene, ss.Camera]:
    path = Path(os.environ.get("SOFTSHADOWS_SCENES", ".")) / "shots" / f"{name}.toml"
    shot = ss.load_shot(path) if path.exists() else under_a_line(name, ss.scenes.make(name))
    return shot.scene, shot.camera


def compare(name: str, size: tuple[int, int]) -> None:
    scene, camera = load(name)
    truth = None
    for label, technique in COMPARED.items():
        frame = ss.render(scene, camera, technique=technique, size=size)
        truth = ss.truth.visibility(scene, frame, samples=512) if truth is None else truth
        error = ss.metrics.compare(frame.visibility[0], truth[0], mask=frame.surface & frame.facing[0])
        print(
            f"{name:15s} {label:13s} rmse {error.rmse:.4f}  leak {error.leak_rate:.1e}  "
            f"false shadow {error.false_shadow_rate:.1e}  maps {frame.stats.shadow_maps}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("names", nargs="+")
    parser.add_argument("--size", default="384x288")
    arguments = parser.parse_args()
    width, height = (int(extent) for extent in arguments.size.split("x"))
    for name in arguments.names:
        compare(name, (width, height))


if __name__ == "__main__":
    main()
