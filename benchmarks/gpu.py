"""Every technique on this machine's graphics card, for gpu.sh: stops at once where the adapter is a CPU.

    python benchmarks/gpu.py FOLDER        [--on-cpu SIZE: try the script itself on a software driver]

Four shots at 1024×768 and 1920×1080. A technique's figures: the median wall time of frames that are read back, and of
frames that are left on the GPU, with the light moved before each; milliseconds by pass; rmse against 33×33 rays of the
GPU's own for each pixel; rays per second, where it traces; bytes. Then what grows: triangles, and lights. After every
picture all that is known is written.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import softshadows as ss
from softshadows.bench.tree_times import OVER_HILLS, SUN, terrain
from softshadows.compare.environment import environment
from softshadows.techniques import TECHNIQUES

SHOTS = ("scorpion", "body", "classroom", "chair_line")
SIZES = ((1024, 768), (1920, 1080))
FRAMES, DRAWN = 5, 20
"""Frames read back one by one, and drawn in a row."""
SECONDS = 420.0
"""After which no picture is begun: the script is to end within eight minutes."""
STEP = 1e-3
"""Metres that the light moves before a frame."""
TRIANGLES, LIGHTS = (1_000, 10_000, 100_000, 1_000_000), (1, 8, 64)
BESIDE: dict[str, ss.techniques.Technique] = {
    "bitmask:rows=16": ss.techniques.Bitmask(rows=16),
    "bitmask:preset=preview": ss.techniques.Bitmask.preset("preview"),
    "adaptive:visibility=ray": ss.techniques.Adaptive(visibility="ray"),
    "uniform:visibility=ray:grid=9": ss.techniques.Uniform(visibility="ray", grid=9),
}
Techniques = Mapping[str, ss.techniques.Technique]
REFERENCE = ss.techniques.Uniform(visibility="ray", grid=33, weights="midpoint")


def techniques() -> Techniques:
    """All with their defaults, and those that trace."""
    return {**{name: cls() for name, cls in TECHNIQUES.items()}, **BESIDE}


def measure(
    scene: ss.Scene, camera: ss.Camera, technique: ss.techniques.Technique, size: tuple[int, int]
) -> tuple[dict[str, Any], ss.Frame | None]:
    """Figures of one technique, and its first frame; a sentence where it cannot be."""
    lights, random = list(scene.lights), np.random.default_rng(0)

    def move() -> None:
        shift = random.uniform(-STEP, STEP, 3)
        scene.lights = [light.moved(shift) for light in lights]

    try:
        with ss.Renderer(scene, technique=technique, size=size) as renderer:
            started = time.perf_counter()
            first = renderer.render(camera)
            compiled = time.perf_counter() - started
            read: list[float] = []
            passes: list[dict[str, float]] = []
            for _ in range(FRAMES):
                move()
                started = time.perf_counter()
                frame = renderer.render(camera)
                read.append(time.perf_counter() - started)
                passes.append(frame.stats.gpu_ms)
            started = time.perf_counter()
            for _ in range(DRAWN - 1):
                move()
                renderer.draw(camera)
            renderer.render(camera)
            drawn = (time.perf_counter() - started) / DRAWN
    except ss.SoftShadowsError as error:
        return {"refused": str(error)}, None
    finally:
        scene.lights = lights
    return {
        "read_back_ms": 1e3 * statistics.median(read),
        "left_on_gpu_ms": 1e3 * drawn,
        "first_frame_ms": 1e3 * compiled,
        "gpu_ms": {name: statistics.median(each.get(name, 0.0) for each in passes) for name in passes[0]},
        "lookups_per_pixel": frame.stats.lookups_per_pixel,
        "rays_per_second": rays_per_second(technique, frame, passes),
        "gpu_bytes": frame.stats.gpu_bytes,
        "warnings": frame.stats.warnings,
    }, first


def rays_per_second(technique: Any, frame: ss.Frame, passes: list[dict[str, float]]) -> float | None:
    """Rays traced in a second, where timestamps tell how long the passes that trace took."""
    seconds = 1e-3 * statistics.median(each.get("trace", 0.0) for each in passes)
    if seconds == 0.0:
        return None
    return frame.stats.lookups_per_pixel * frame.surface.size * len(frame.lights) / seconds


def picture(name: str, scene: ss.Scene, camera: ss.Camera, size: tuple[int, int], chosen: Techniques) -> dict[str, Any]:
    """All techniques on one view."""
    reference = reference_of(scene, camera, size)
    rows: dict[str, Any] = {}
    for label, technique in chosen.items():
        figures, frame = measure(scene, camera, technique, size)
        if frame is not None and reference is not None:
            mask = frame.surface & frame.facing[0]
            figures["rmse"] = ss.metrics.compare(frame.visibility[0], reference.visibility[0], mask=mask).rmse
        rows[label] = figures
        said = (
            figures.get("refused") or f"{figures['read_back_ms']:.2f} ms, left there {figures['left_on_gpu_ms']:.2f} ms"
        )
        print(f"{name} {size[0]}x{size[1]} {label}: {said}", flush=True)
    return {"scene": name, "size": list(size), "triangles": scene.triangle_count, "techniques": rows}


def reference_of(scene: ss.Scene, camera: ss.Camera, size: tuple[int, int]) -> ss.Frame | None:
    """A frame by many rays; None where the adapter cannot do it."""
    try:
        return ss.render(scene, camera, technique=REFERENCE, size=size)
    except ss.SoftShadowsError:
        return None


def growth() -> Iterator[tuple[str, ss.Scene, ss.Camera, Techniques]]:
    """Views in which one thing grows, by what it is called: opened when their turn comes."""
    few = {label: BESIDE.get(label) or TECHNIQUES[label]() for label in ("bitmask", "adaptive:visibility=ray")}
    for count in TRIANGLES:
        scene = terrain(count)
        scene.lights, scene.camera = [SUN], OVER_HILLS
        yield f"hills {count}", scene, OVER_HILLS, few
    for count in LIGHTS:
        scene = ss.scenes.make("figures")
        (light,) = scene.lights
        scene.lights = [light.moved((0.05 * place, 0.0, 0.0)) for place in range(count)]
        assert scene.camera is not None
        yield f"lights {count}", scene, scene.camera, {"bitmask": TECHNIQUES["bitmask"]()}


def views(sizes: tuple[tuple[int, int], ...]) -> Iterator[tuple[str, ss.Scene, ss.Camera, tuple[int, int], Techniques]]:
    """The shots at all sizes, smaller ones first, then what grows."""
    for size in sizes:
        for name in SHOTS:
            shot = ss.load_shot(Path(os.environ["SOFTSHADOWS_SCENES"]) / "shots" / f"{name}.toml")
            yield name, shot.scene, shot.camera, size, techniques()
    for name, scene, camera, chosen in growth():
        yield name, scene, camera, sizes[0], chosen


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--on-cpu", default="", metavar="SIZE", help="try the script on a CPU at this size")
    arguments = parser.parse_args()
    about = environment()
    adapter = about["adapter"]
    print(json.dumps(adapter, default=str), flush=True)
    if adapter["type"] == "CPU" and not arguments.on_cpu:
        sys.exit("this adapter is a CPU: nothing to measure here")
    sizes = SIZES
    if arguments.on_cpu:
        width, height = arguments.on_cpu.split("x")
        sizes = ((int(width), int(height)),)
    started = time.monotonic()
    pictures: list[Any] = []
    name = "".join(letter if letter.isalnum() else "-" for letter in adapter["adapter"].split(" (")[0].lower())
    for view in views(sizes):
        if time.monotonic() - started > SECONDS:
            print("out of time: the rest is left out", flush=True)
            break
        pictures.append(picture(*view))
        text = json.dumps({"schema": "softshadows-gpu/1", "environment": about, "pictures": pictures}, default=str)
        arguments.folder.mkdir(parents=True, exist_ok=True)
        part = arguments.folder / f".gpu-{name}.json"
        part.write_text(text, "utf-8")
        part.replace(arguments.folder / f"gpu-{name}.json")  # in one step, since a time limit may end the script here


if __name__ == "__main__":
    main()
