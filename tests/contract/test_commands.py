"""The commands of a frame can be replayed elsewhere: they never depend on the camera, whose data come in writes."""

from __future__ import annotations

import dataclasses

import pytest

import softshadows as ss
import stage
from recorder import Recording, recording
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.techniques import TECHNIQUES, Technique

CAMERAS = [
    stage.CAMERA,
    ss.Camera((0.0, 9.0, 0.1), (0.0, 0.0, 0.0)),
    ss.Camera((0.0, 2.0, 0.0), (0.0, 9.0, 1.0)),  # sees nothing
]
BESIDE: dict[str, Technique] = {
    "uniform-ray": ss.techniques.Uniform(grid=4, visibility="ray"),
    "adaptive-ray": ss.techniques.Adaptive(max_depth=2, visibility="ray"),
    "adaptive-hybrid": ss.techniques.Adaptive(max_depth=2, visibility="hybrid", resolution=256),
}
SUBJECTS = {**{name: stage.cheap(name) for name in TECHNIQUES}, **BESIDE}

every_subject = pytest.mark.parametrize("name", list(SUBJECTS))


def recorded(renderer: ss.Renderer, camera: ss.Camera) -> Recording:
    """A frame, encoded and thrown away."""
    gpu = acquire()
    with recording(gpu) as record:
        renderer.prepare()
        renderer.write(camera)
        assert renderer.passes is not None
        renderer.encode(Commands(gpu, renderer.passes.timer))
    return record


@every_subject
def test_the_commands_do_not_depend_on_the_camera(name: str) -> None:
    """Nor does any write but the camera's own."""
    scene = stage.standard_scene(stage.light_for(name.split("-")[0]))
    with ss.Renderer(scene, technique=SUBJECTS[name], size=stage.SIZE) as renderer:
        renderer.render(stage.CAMERA)  # builds, and writes what is constant
        first, *others = (recorded(renderer, camera) for camera in CAMERAS)
        assert first.count("dispatch_workgroups") >= 2
        for other in others:
            assert other.commands == first.commands
            fixed, same = ([write for write in each.writes if write[3] != "camera"] for each in (first, other))
            assert fixed == same
            assert [write[:2] for write in other.writes] == [write[:2] for write in first.writes]
            assert other.writes != first.writes


def test_the_recorder_sees_a_difference() -> None:
    """The test above can fail."""
    scene = stage.standard_scene()
    with ss.Renderer(scene, technique=stage.cheap("hard"), size=stage.SIZE) as renderer:
        renderer.render(stage.CAMERA)
        first = recorded(renderer, stage.CAMERA)
        scene.lights = [dataclasses.replace(stage.RECT, width=2.0)]
        moved = recorded(renderer, stage.CAMERA)
        assert {write[3] for write in moved.writes} > {"camera"}
        scene.lights = [stage.RECT, stage.RECT]
        assert recorded(renderer, stage.CAMERA).commands != first.commands
