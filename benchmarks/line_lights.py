"""Line lights: error against rays of soft shadow maps and of plain sampling, and time over two hard shadows.

    python benchmarks/line_lights.py chair_line bike_line classroom_tube figures fence sphere_cube atrium
    python benchmarks/line_lights.py --time chair_line bike_line

A name is a shot in SOFTSHADOWS_SCENES, or a built-in scene, whose first light becomes a line along its right axis.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
from pathlib import Path

import numpy as np

import softshadows as ss
from softshadows.techniques import LineShadowMaps, Technique, Uniform

PAPER = {"samples": 2, "transition": "linear", "seen_by_both": "all", "gaps": "none"}
COMPARED: dict[str, Technique] = {
    "paper": LineShadowMaps(**PAPER),
    "two samples": LineShadowMaps(samples=2),
    "five samples": LineShadowMaps(samples=5),
    "auto": LineShadowMaps(),
    **{f"uniform {grid}": Uniform(grid=grid) for grid in (5, 9, 17)},
}
TIMED: dict[str, Technique] = {
    "uniform 2": Uniform(grid=2, resolution=500),
    "paper": LineShadowMaps.preset("paper"),
    "two samples": LineShadowMaps(samples=2, resolution=500),
}
NUDGE = 1e-4
"""Metres that a light moves so that everything is drawn again."""
ROUNDS = 4


def load(name: str) -> tuple[ss.Scene, ss.Camera]:
    path = Path(os.environ.get("SOFTSHADOWS_SCENES", ".")) / "shots" / f"{name}.toml"
    if path.exists():
        shot = ss.load_shot(path)
        return shot.scene, shot.camera
    scene = ss.scenes.make(name)
    light, camera = scene.lights[0], scene.camera
    assert camera is not None
    reach = light.half_extent[0] * light.axes[0]
    start, end = light.center - reach, light.center + reach
    scene.lights = [ss.LineLight(tuple(start.tolist()), tuple(end.tolist()), (30.0, 30.0, 30.0))]
    return scene, camera


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


def measure(name: str, size: tuple[int, int]) -> None:
    """Medians of frames in turns, all redrawn and with maps kept, over those of two hard shadows."""
    scene, camera = load(name)
    light = scene.lights[0]
    assert isinstance(light, ss.LineLight)
    x, y, z = light.start
    lights = [light, dataclasses.replace(light, start=(x + NUDGE, y, z))]
    renderers = {label: ss.Renderer(scene, technique=technique, size=size) for label, technique in TIMED.items()}
    times: dict[str, list[list[float]]] = {label: [] for label in TIMED}
    for turn in range(ROUNDS):
        scene.lights = [lights[turn % 2]]
        for label, renderer in renderers.items():
            times[label].append([sum(renderer.render(camera).stats.gpu_ms.values()) for _ in range(2)])
    medians = {label: np.median(rows[1:], axis=0) for label, rows in times.items()}
    for label, (redrawn, kept) in medians.items():
        base = medians["uniform 2"]
        print(f"{name:15s} {label:13s} redrawn {redrawn / base[0]:.2f}  kept {kept / base[1]:.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("names", nargs="+")
    parser.add_argument("--size", default="384x288")
    parser.add_argument("--time", action="store_true", help="time in place of error")
    arguments = parser.parse_args()
    width, height = (int(extent) for extent in arguments.size.split("x"))
    for name in arguments.names:
        (measure if arguments.time else compare)(name, (width, height))


if __name__ == "__main__":
    main()
