"""A frame in which lights have techniques of their own: each fills its lights' layers of visibility, and no others."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
import stage
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.gpu.shared_scene import open_scene
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.techniques import TECHNIQUES, Technique
from softshadows.techniques.frame_passes import FramePasses

BESIDE: dict[str, Technique] = {
    "uniform-denoised": ss.techniques.make_technique(
        "uniform", {"grid": 3, "visibility": "ray", "visibility.offsets": "stratified", "visibility.denoise": True}
    )
}
SUBJECTS = {**{name: stage.cheap(name) for name in TECHNIQUES}, **BESIDE}


def layers(scene: ss.Scene, techniques: Sequence[Technique]) -> npt.NDArray[np.float32]:
    """(lights, height, width): the visibility of a frame with these techniques, light by light."""
    gpu = acquire().owner()
    shared = open_scene(gpu, scene)
    passes = FramePasses(gpu, GBuffer(gpu, shared.update(), stage.SIZE), lambda light: techniques[light])
    passes.prepare(len(scene.lights))
    passes.gbuffer.write(stage.CAMERA)
    passes.groups.write(scene.lights)
    commands = Commands(gpu, passes.timer)
    passes.gbuffer.encode(commands)
    passes.groups.encode(commands)
    commands.submit()
    words = np.frombuffer(gpu.device.queue.read_buffer(passes.images.visibility), np.float32)
    assert len(passes.groups.passes) == len(set(techniques))
    assert len(passes.groups.results) == sum(len(each.results) for each in passes.groups.passes)
    passes.release()
    shared.close()
    width, height = stage.SIZE
    return words.reshape(-1, height, width)


@pytest.mark.parametrize("name", list(SUBJECTS))
def test_every_light_is_done_by_its_technique(name: str) -> None:
    """Between, before and after lights of another one: each layer is that of a frame with this light alone."""
    technique, other = SUBJECTS[name], ss.techniques.Pcf(kernel=3, resolution=256)
    light: Any = stage.light_for(name.split("-")[0])
    aside = dataclasses.replace(stage.RECT, position=(-1.5, 3.0, 1.0))
    scene = stage.standard_scene()
    scene.lights = [aside, light, stage.RECT, light]
    techniques = [other, technique, other, technique]
    for order in ([0, 1, 2, 3], [1, 0, 3, 2]):
        scene.lights = [scene.lights[index] for index in order]
        techniques = [techniques[index] for index in order]
        found = layers(scene, techniques)
        for layer, (own, each) in enumerate(zip(scene.lights, techniques, strict=True)):
            alone = stage.render(ss.Scene(scene.nodes, [own]), each)
            assert stage.same_bits(found[layer], alone.visibility[0]), f"layer {layer}, {each.name}"
