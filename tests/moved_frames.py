"""Frames in which the light, the camera or a node moves, and how many files each adds to the driver's shader cache.

    python tests/moved_frames.py LABEL ...

With MESA_SHADER_CACHE_DIR an empty folder. Prints JSON: by label of benchmarks/same_frames.py the files that came with
the first frames, and those that came with each kind of move after them. Run in a process of its own, since a driver
reads the environment once.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import sys
import time
from pathlib import Path
from types import ModuleType

import numpy as np

import softshadows as ss

SIZE = (64, 48)


def same_frames() -> ModuleType:
    """benchmarks/same_frames.py, whose CONFIGS are every technique and its main options."""
    path = Path(__file__).resolve().parent.parent / "benchmarks" / "same_frames.py"
    spec = importlib.util.spec_from_file_location("same_frames", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["same_frames"] = module
    spec.loader.exec_module(module)
    return module


class Stage:
    """`figures` under a rectangle and a line, of which the technique does one or both."""

    def __init__(self, technique: ss.techniques.Technique, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.scene = ss.scenes.make("figures")
        (rect,) = self.scene.lights
        assert isinstance(rect, ss.RectLight)
        x, y, z = rect.position
        line = ss.LineLight((x - 0.5, y, z), (x + 0.5, y, z), (10.0, 10.0, 10.0))
        self.lights = [light for light in (rect, line) if light.kind in technique.light_kinds]
        assert self.scene.camera is not None
        self.camera = self.first_camera = self.scene.camera
        self.transforms = [np.array(node.transform) for node in self.scene.nodes]
        self.scene.lights = list(self.lights)

    def _near(self, point: tuple[float, float, float], reach: float) -> tuple[float, float, float]:
        x, y, z = np.asarray(point) + self.random.uniform(-reach, reach, 3)
        return float(x), float(y), float(z)

    def _moved(self, light: ss.Light) -> ss.Light:
        if isinstance(light, ss.RectLight):
            return dataclasses.replace(
                light, position=self._near(light.position, 0.8), target=self._near(light.target, 0.3)
            )
        assert isinstance(light, ss.LineLight)
        return dataclasses.replace(light, start=self._near(light.start, 0.4), end=self._near(light.end, 0.4))

    def move_light(self) -> None:
        self.scene.lights = [self._moved(light) for light in self.lights]

    def move_camera(self) -> None:
        camera = self.first_camera
        self.camera = dataclasses.replace(
            camera, position=self._near(camera.position, 0.5), target=self._near(camera.target, 0.2)
        )

    def move_nodes(self) -> None:
        for node, transform in list(zip(self.scene.nodes, self.transforms, strict=True))[1:]:
            node.transform = transform.copy()
            node.transform[:3, 3] += self.random.uniform(-0.2, 0.2, 3)

    def move_all(self) -> None:
        self.move_light()
        self.move_camera()
        self.move_nodes()


def count(cache: Path) -> int:
    """The files in the cache, once the driver's thread that writes them has been quiet for a while."""
    files, quiet = -1, 0
    while quiet < 3:
        time.sleep(0.015)
        found = sum(len(names) for _, _, names in os.walk(cache))
        quiet = quiet + 1 if found == files else 0
        files = found
    return files


def files_added(technique: ss.techniques.Technique, cache: Path, seed: int) -> dict[str, int]:
    """The new files of the first two frames, between which everything moves, and of each kind of move after them."""
    files = count(cache)

    def added() -> int:
        nonlocal files
        before, files = files, count(cache)
        return files - before

    stage = Stage(technique, seed)
    found: dict[str, int] = {}
    moves = {"light": stage.move_light, "camera": stage.move_camera, "nodes": stage.move_nodes}
    with ss.Renderer(stage.scene, technique=technique, size=SIZE) as renderer:
        renderer.render(stage.camera)
        stage.move_all()
        renderer.render(stage.camera)
        found["first"] = added()
        for name, move in moves.items():
            move()
            renderer.render(stage.camera)
            found[name] = added()
    return found


def main(labels: list[str]) -> None:
    cache = Path(os.environ["MESA_SHADER_CACHE_DIR"])
    configs = {config.label: config for config in same_frames().CONFIGS}
    found = {label: files_added(configs[label].make(), cache, seed) for seed, label in enumerate(labels)}
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1:])
