"""What renderers share: compiled pipelines, and a scene's copy on the device, counted and released."""

from __future__ import annotations

import gc
import threading
from typing import Any

import numpy as np
import pytest
from wgpu.backends import wgpu_native

import softshadows as ss
import stage
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.gpu.shared_scene import open_scene
from softshadows.passes.gbuffer.gbuffer import GBuffer
from softshadows.techniques import TECHNIQUES
from softshadows.techniques.frame_passes import FramePasses

all_techniques = pytest.mark.parametrize("name", list(TECHNIQUES))
OTHER_CAMERA = ss.Camera((-1.0, 2.0, 2.5), (0.0, 0.2, 0.0), 50.0)


def scene_of(name: str) -> ss.Scene:
    return stage.standard_scene(stage.light_for(name))


def lift(scene: ss.Scene, height: float) -> None:
    """Move the card."""
    scene.nodes[1] = stage.moved(scene.nodes[1], (0.0, height, 0.0))


@all_techniques
def test_a_second_renderer_and_more_lights_compile_nothing(name: str) -> None:
    """Nor does a light that is taken away."""
    gpu, scene, light = acquire(), scene_of(name), stage.light_for(name)
    stage.render(scene, stage.cheap(name))
    compiled = set(gpu.pipelines)
    with ss.Renderer(scene, technique=stage.cheap(name), size=(40, 30)) as renderer:
        renderer.render(stage.CAMERA)
        assert renderer.passes is not None
        at_work = renderer.passes.technique
        for lights in ([light, light], [light, light, light], [light]):
            scene.lights = lights
            frame = renderer.render(stage.CAMERA)
            assert set(gpu.pipelines) == compiled
            assert renderer.passes.technique is at_work, "the pass was built again"
            for layer in frame.visibility[1:]:
                assert stage.same_bits(layer, frame.visibility[0])


def test_lights_that_come_and_go_leave_nothing_behind() -> None:
    """On the GPU: what grew stays, what was made for a number of lights goes."""
    scene = stage.standard_scene()
    with ss.Renderer(scene, technique=stage.cheap("hard"), size=stage.SIZE) as renderer:
        counts = []
        for number in range(8):
            scene.lights = [stage.RECT] * (1 + number % 3)
            renderer.draw(stage.CAMERA)
            renderer.render(stage.CAMERA)
            assert renderer.passes is not None
            counts.append([len(owner.owned or []) for owner in (renderer.passes._gpu, renderer.passes._reading)])
    assert counts[3:] == counts[2:3] * 5


def test_passes_opened_together_share_what_the_camera_sees() -> None:
    """Two techniques side by side, on one G-buffer, in one frame."""
    gpu, scene = acquire().owner(), stage.standard_scene()
    shared = open_scene(gpu, scene)
    gbuffer = GBuffer(gpu, shared.update(), stage.SIZE)
    techniques = [stage.cheap("hard"), stage.cheap("pcss")]
    beside = [FramePasses(gpu.owner(), gbuffer, lambda light, each=each: each) for each in techniques]
    commands = Commands(gpu, beside[0].timer)
    gbuffer.write(stage.CAMERA)
    gbuffer.encode(commands)
    for passes in beside:
        passes.prepare(len(scene.lights))
        passes.groups.write(scene.lights, 0)
        passes.groups.encode(commands)
    commands.submit()
    for technique, passes in zip(techniques, beside, strict=True):
        found = np.frombuffer(gpu.device.queue.read_buffer(passes.images.visibility), np.float32)
        assert stage.same_bits(found, stage.render(scene, technique).visibility.ravel())
        passes.release()
    gpu.release()
    shared.close()


def test_a_new_technique_compiles() -> None:
    """The test above can fail."""
    gpu = acquire()
    stage.render(stage.standard_scene(), stage.cheap("hard"))
    compiled = len(gpu.pipelines)
    stage.render(stage.standard_scene(), ss.techniques.Pcf(kernel=7, spread=1.7, resolution=64))
    assert len(gpu.pipelines) > compiled


@all_techniques
def test_two_renderers_of_a_scene_share_it_and_are_both_right(name: str) -> None:
    """Also where nodes move between their frames, one after the other, and where meshes come and go."""
    scene, technique = scene_of(name), stage.cheap(name)

    def check(renderer: ss.Renderer, camera: ss.Camera) -> None:
        fresh = ss.Scene(list(scene.nodes), list(scene.lights))
        expected = stage.render(fresh, technique, renderer.size, camera)
        assert stage.same_bits(renderer.render(camera).visibility, expected.visibility)

    with (
        ss.Renderer(scene, technique=technique, size=(40, 30)) as one,
        ss.Renderer(scene, technique=technique, size=stage.SIZE) as two,
    ):
        check(one, stage.CAMERA)
        check(two, OTHER_CAMERA)
        assert one.passes is not None
        assert two.passes is not None
        assert one.passes.gbuffer.scene is two.passes.gbuffer.scene
        lift(scene, 0.5)
        check(two, stage.CAMERA)
        check(one, OTHER_CAMERA)
        lift(scene, -0.3)
        check(two, stage.CAMERA)
        lift(scene, 0.2)
        check(one, stage.CAMERA)
        check(two, stage.CAMERA)
        scene.nodes.append(stage.box((-1.4, 0.0, 0.8), (-0.9, 0.5, 1.3)))
        check(one, stage.CAMERA)
        check(two, OTHER_CAMERA)
        two.invalidate()
        check(one, stage.CAMERA)
        check(two, stage.CAMERA)


@pytest.mark.parametrize("name", ["hard", "uniform", "adaptive", "penumbra_wedges"])
def test_two_threads_render_the_same_scene(name: str) -> None:
    """Each with a renderer of its own, from its own side."""
    scene, technique = scene_of(name), stage.cheap(name)
    cameras = (stage.CAMERA, OTHER_CAMERA)
    expected = [stage.render(scene, technique, stage.SIZE, camera) for camera in cameras]
    wrong: list[Any] = []

    def work(which: int) -> None:
        try:
            for _ in range(3):
                with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:
                    for _ in range(3):
                        frame = renderer.render(cameras[which])
                        if not stage.same_bits(frame.visibility, expected[which].visibility):
                            wrong.append(which)
        except Exception as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(which,)) for which in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
    assert id(scene) not in acquire().scenes


def test_a_scene_leaves_the_device_with_its_last_user() -> None:
    gpu, scene = acquire(), stage.standard_scene()
    with ss.Renderer(scene, technique="hard", size=stage.SIZE) as one:
        one.render(stage.CAMERA)
        with ss.Renderer(scene, technique="none", size=stage.SIZE) as two:
            two.render(stage.CAMERA)
            assert gpu.scenes[id(scene)].users == 2
        assert gpu.scenes[id(scene)].users == 1
        one.render(stage.CAMERA)
    assert id(scene) not in gpu.scenes
    one.render(stage.CAMERA)  # opens it again
    assert gpu.scenes[id(scene)].users == 1
    del one
    gc.collect()
    assert id(scene) not in gpu.scenes


@pytest.mark.parametrize("leave", [ss.Renderer.invalidate, ss.Renderer.__exit__])
def test_what_is_released_is_destroyed(leave: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Buffers and textures of the renderer and of its scene. To use one then would end the process."""
    destroyed: list[Any] = []
    for cls in (wgpu_native.GPUBuffer, wgpu_native.GPUTexture):
        destroy = cls.destroy
        monkeypatch.setattr(cls, "destroy", lambda self, destroy=destroy: (destroyed.append(self), destroy(self))[1])
    renderer = ss.Renderer(stage.standard_scene(), technique=stage.cheap("uniform"), size=stage.SIZE)
    before = renderer.render(stage.CAMERA)
    images, passes = renderer.images, renderer.passes
    assert passes is not None
    atlas = passes.technique.by_light[0][0]  # type: ignore[attr-defined]
    base = [images.color, images.visibility, images.position, images.normal, atlas.depth, atlas.views]
    base += [passes.gbuffer.scene.positions, passes.gbuffer.scene.pages, passes.readback._staging]
    leave(renderer)
    assert all(any(each is item for item in destroyed) for each in base)
    after = renderer.render(stage.CAMERA)
    assert stage.same_bits(after.visibility, before.visibility)
    assert np.array_equal(after.color, before.color)
    renderer.__exit__()
