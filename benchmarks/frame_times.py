"""Does a version of softshadows take longer for a frame than another?

    python benchmarks/frame_times.py BEFORE/src AFTER/src [--size 320x240] [--frames 7] [--labels "hard|pcss"]

Two processes, one with each version, draw the techniques of same_frames.py on built-in scenes under a rectangle and
under a line, interleaved and never at once; the light moves a little before every frame, to the same places in both.
Prints the medians and their ratio for every view, and over all of them.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from same_frames import CONFIGS, under_a_line

import softshadows as ss

SCENES = ("figures", "sphere_cube", "room", "fence", "figures, line", "fence, line")
LABELS = (
    "none|hard|pcf|pcss|vsm|uniform|uniform rays|uniform hybrid|adaptive|adaptive rays|adaptive hybrid|adaptive cell|"
    "variable_penumbra|variable_penumbra from_light|line_shadow_maps|occluding_edges|penumbra_wedges|"
    "penumbra_wedges union"
)
REACH = 0.01  # metres that the light moves by


class Version:
    """A process that draws frames with one version, as `main` of this file with `--work`."""

    def __init__(self, source: str) -> None:
        command = [sys.executable, __file__, "--work"]
        environment = {**os.environ, "PYTHONPATH": source}
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, **question: Any) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps(question), file=self._process.stdin, flush=True)
        return json.loads(self._process.stdout.readline())


def compare(before: Version, after: Version, size: tuple[int, int], frames: int, labels: list[str]) -> None:
    sums, logarithms = [0.0, 0.0], []
    for scene in SCENES:
        for label in labels:
            if not all([version.ask(scene=scene, label=label, size=size) for version in (before, after)]):
                continue  # a kind of light that the technique does not do
            times: dict[Version, list[float]] = {before: [], after: []}
            for number in range(frames):
                for version in (before, after) if number % 2 == 0 else (after, before):
                    times[version].append(version.ask(frame=number))
            first, second = statistics.median(times[before]), statistics.median(times[after])
            sums = [sums[0] + first, sums[1] + second]
            logarithms.append(math.log(second / first))
            print(f"{scene:14} {label:28} {first:8.1f} -> {second:8.1f} ms, {second / first:.3f}", flush=True)
    mean = math.exp(statistics.fmean(logarithms))
    print(f"{len(logarithms)} views: sum of times {sums[1] / sums[0]:.3f}, geometric mean of ratios {mean:.3f}")


def work() -> None:
    """Answer questions, a line of JSON each: whether a view can be drawn, and how long a frame of it takes."""
    configs = {config.label: config for config in CONFIGS}
    renderer = scene = None
    lights: list[Any] = []
    for line in sys.stdin:
        question = json.loads(line)
        if "scene" in question:
            if renderer is not None:
                renderer.__exit__(None, None, None)
            renderer, scene = open_view(configs[question["label"]].make(), question["scene"], tuple(question["size"]))
            lights = list(scene.lights)
            answer: object = renderer is not None
        else:
            assert renderer is not None
            assert scene is not None
            shift = np.random.default_rng(question["frame"]).uniform(-REACH, REACH, 3)
            scene.lights = [moved(light, shift) for light in lights]
            started = time.perf_counter()
            renderer.render(scene.camera)
            answer = 1e3 * (time.perf_counter() - started)
        print(json.dumps(answer), flush=True)


def open_view(
    technique: ss.techniques.Technique, name: str, size: tuple[int, int]
) -> tuple[ss.Renderer | None, ss.Scene]:
    """A renderer that has drawn two frames; None where the technique refuses the light."""
    builtin, _, line = name.partition(", ")
    scene = ss.scenes.make(builtin)
    if line:
        under_a_line(scene)
    assert scene.camera is not None
    renderer = ss.Renderer(scene, technique=technique, size=size)
    try:
        renderer.render(scene.camera)
        renderer.render(scene.camera)
    except ss.OptionError:
        renderer.__exit__(None, None, None)
        return None, scene
    return renderer, scene


def moved(light: Any, shift: np.ndarray) -> Any:
    """The light elsewhere, still aimed at its target."""
    points = ("start", "end") if hasattr(light, "start") else ("position",)
    return dataclasses.replace(light, **{point: tuple(np.add(getattr(light, point), shift)) for point in points})


def main() -> None:
    if sys.argv[1:] == ["--work"]:
        work()
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--frames", type=int, default=7)
    parser.add_argument("--labels", default=LABELS)
    arguments = parser.parse_args()
    width, height = arguments.size.split("x")
    before, after = (Version(str(source.resolve())) for source in (arguments.before, arguments.after))
    compare(before, after, (int(width), int(height)), arguments.frames, arguments.labels.split("|"))


if __name__ == "__main__":
    main()
