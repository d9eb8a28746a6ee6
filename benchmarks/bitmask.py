"""The technique `bitmask` on real shots: errors, what walks meet, and processor time beside adaptive sampling by rays.

    python benchmarks/bitmask.py scorpion body classroom --size 512x384 [--samples 1024] [--rows 4 8 16 32]

A name is a shot in SOFTSHADOWS_SCENES, or a built-in scene. Before every timed frame the lights move, so that trees are
fitted to them anew; times are processor seconds of the whole process, medians, interleaved with the other techniques.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from pathlib import Path

import numpy as np

import softshadows as ss
from softshadows.techniques.bitmask.bitmask import BitmaskPass
from softshadows.techniques.bitmask.pictures import look

STEP = 1e-3
"""Metres that lights move from frame to frame, at most."""


def load(name: str) -> tuple[ss.Scene, ss.Camera]:
    path = Path(os.environ.get("SOFTSHADOWS_SCENES", ".")) / "shots" / f"{name}.toml"
    if path.exists():
        shot = ss.load_shot(path)
        return shot.scene, shot.camera
    scene = ss.scenes.make(name)
    assert scene.camera is not None
    return scene, scene.camera


def measure(name: str, size: tuple[int, int], samples: int, rows: list[int], repeats: int) -> None:
    scene, camera = load(name)
    lights, random = list(scene.lights), np.random.default_rng(0)
    techniques = {f"bitmask, {count} rows": ss.techniques.Bitmask(rows=count) for count in rows}
    techniques["adaptive by rays"] = ss.techniques.Adaptive(visibility="ray")
    renderers = {label: ss.Renderer(scene, technique=each, size=size) for label, each in techniques.items()}
    frames = {label: renderer.render(camera) for label, renderer in renderers.items()}
    first = next(iter(frames.values()))
    truth = ss.truth.visibility(scene, first, samples=samples)[0]
    seconds: dict[str, list[float]] = {label: [] for label in renderers}
    for _ in range(repeats):
        scene.lights = [light.moved(random.uniform(-STEP, STEP, 3)) for light in lights]
        for label, renderer in renderers.items():
            started = time.process_time()
            renderer.render(camera)
            seconds[label].append(time.process_time() - started)
    for label, frame in frames.items():
        error = ss.metrics.compare(frame.visibility[0], truth, mask=frame.surface & frame.facing[0])
        at_work = renderers[label].passes.technique
        met = ""
        if isinstance(at_work, BitmaskPass):
            seen = look(at_work, scene.lights[0], 0)
            boxes, triangles = (float(each[frame.surface].mean()) for each in (seen.boxes, seen.triangles))
            met = f"  {boxes:.0f} boxes, {triangles:.0f} triangles a pixel"
        print(
            f"{name:15s} {label:17s} rmse {error.rmse:.4f}  bias {error.bias:+.4f}  leaks {error.leak_rate:.1e}  "
            f"false shadow {error.false_shadow_rate:.1e}  {1e3 * statistics.median(seconds[label]):.0f} ms{met}",
            flush=True,
        )
    for renderer in renderers.values():
        renderer.__exit__(None, None, None)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("names", nargs="+")
    parser.add_argument("--size", default="512x384")
    parser.add_argument("--samples", type=int, default=1024)
    parser.add_argument("--rows", type=int, nargs="+", default=[8])
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    width, height = (int(extent) for extent in arguments.size.split("x"))
    for name in arguments.names:
        measure(name, (width, height), arguments.samples, arguments.rows, arguments.repeats)


if __name__ == "__main__":
    main()
