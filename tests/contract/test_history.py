"""A frame depends on its scene, lights and camera alone, never on the frames before it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from moved_frames import Stage
from softshadows.techniques import TECHNIQUES, Technique

BEFORE = 20
"""Frames with other cameras and lights."""
SIZE = (40, 30)
BESIDE: dict[str, Technique] = {
    "uniform-hybrid": ss.techniques.Uniform(grid=3, visibility="hybrid", resolution=256),
    "adaptive-global": ss.techniques.Adaptive(max_depth=2, refinement="global", resolution=256),
}
SUBJECTS = {**{name: stage.cheap(name) for name in TECHNIQUES}, **BESIDE}


def light_at(light: Any, offset: np.ndarray) -> Any:
    """The light elsewhere; a sun has no place, but a direction."""
    fields = {field.name for field in dataclasses.fields(light)}
    name = next(iter(fields & {"position", "direction"}), None)
    if name is not None:
        return dataclasses.replace(light, **{name: tuple(np.add(getattr(light, name), offset))})
    return dataclasses.replace(light, start=tuple(np.add(light.start, offset)), end=tuple(np.add(light.end, offset)))


@pytest.mark.parametrize("name", list(SUBJECTS))
def test_a_frame_is_that_of_a_new_renderer_whatever_came_before(name: str) -> None:
    """To the last bit: after cameras that see more, less and nothing, near and far, and lights here and there.

    Most frames leave the light where it is, so that maps which outlive a frame have every reason to.
    """
    random = np.random.default_rng(5)
    light = stage.light_for(name.split("-")[0])
    scene = stage.standard_scene(light)
    with ss.Renderer(scene, technique=SUBJECTS[name], size=SIZE) as renderer:
        for number in range(BEFORE + 1):
            position = tuple(
                np.multiply(stage.CAMERA.position, random.uniform(0.6, 1.7)) + random.uniform(-0.6, 0.6, 3)
            )
            camera = dataclasses.replace(stage.CAMERA, position=position, vertical_fov=random.uniform(20.0, 80.0))
            if number % 6 == 4:
                camera = dataclasses.replace(camera, target=(0.0, 9.0, 0.1))
            if number % 5 == 3:
                light = light_at(light, random.uniform(-0.2, 0.2, 3))
            scene.lights = [light]
            frame = renderer.render(camera)
            if number % 4 == 0:
                expected = stage.render(scene, SUBJECTS[name], SIZE, camera)
                assert stage.same_bits(frame.visibility, expected.visibility), f"frame {number} of {BEFORE}"
                assert stage.same_bits(frame.color, expected.color)


@pytest.mark.parametrize("name", TECHNIQUES)
def test_a_moved_light_leaves_nothing_behind(name: str) -> None:
    """To the last bit, where the light goes far: to other numbers of samples, sizes of maps and lengths of lists."""
    technique = stage.cheap(name)
    moving = Stage(technique, seed=0)
    with ss.Renderer(moving.scene, technique=technique, size=SIZE) as renderer:
        for number in range(6):
            moving.move_light()
            frame = renderer.render(moving.camera)
            expected = stage.render(moving.scene, technique, SIZE, moving.camera)
            assert stage.same_bits(frame.visibility, expected.visibility), f"frame {number}"
