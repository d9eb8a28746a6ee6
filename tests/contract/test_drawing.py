"""Frames that stay on the GPU: the same pictures, nothing read, nothing waited for; and what they cost, known later."""

from __future__ import annotations

import dataclasses
import time
from collections import Counter
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import wgpu
from wgpu.backends import wgpu_native

import softshadows as ss
import stage
from recorder import recording
from softshadows.gpu.device import acquire
from softshadows.gpu.readback import RING, Readback
from softshadows.techniques import TECHNIQUES, Uniform

all_techniques = pytest.mark.parametrize("name", list(TECHNIQUES))
PATIENCE = 20.0
"""Seconds in which a tiny frame is drawn, however busy the machine."""
SMALL = 4096
"""Bytes of a frame's statistics, about."""


def finished(renderer: ss.Renderer, number: int) -> ss.FrameStats:
    """The statistics of that frame, once they are there."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        stats = renderer.finished()
        if stats is not None and stats.number >= number:
            return stats
        time.sleep(0.002)
    raise AssertionError(f"frame {number} has not finished within {PATIENCE:g} s")


def on_gpu(renderer: ss.Renderer) -> dict[str, npt.NDArray[np.float32]]:
    """The images as they are on the GPU."""
    images, queue, (width, height) = renderer.images, acquire().device.queue, renderer.size
    layout = {"bytes_per_row": 16 * width, "rows_per_image": height}
    found = {
        name: np.frombuffer(queue.read_texture({"texture": texture}, layout, (width, height, 1)), np.float32)
        for name, texture in (("color", images.color), ("position", images.position), ("normal", images.normal))
    }
    shape = (-1, height, width)
    visibility = np.frombuffer(queue.read_buffer(images.visibility), np.float32).reshape(shape)
    return {"visibility": visibility, **{name: image.reshape(height, width, 4) for name, image in found.items()}}


def same_images(images: dict[str, npt.NDArray[np.float32]], frame: ss.Frame) -> bool:
    layers = images["visibility"][: len(frame.lights)]
    return stage.same_bits(layers, frame.visibility) and all(
        stage.same_bits(np.ascontiguousarray(images[name][..., :3]), getattr(frame, name))
        for name in ("color", "position", "normal")
    )


@all_techniques
def test_drawn_images_are_the_rendered_ones(name: str) -> None:
    """Bit for bit, and so are the statistics that arrive later."""
    scene = stage.standard_scene(stage.light_for(name))
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        assert renderer.finished() is None
        number = renderer.draw(stage.CAMERA)
        drawn = on_gpu(renderer)
        stats = finished(renderer, number)
        frame = renderer.render(stage.CAMERA)
    assert same_images(drawn, frame)
    assert number == stats.number == 1
    for field in ("shadow_maps", "lookups_per_pixel", "warnings", "submits"):
        assert getattr(stats, field) == getattr(frame.stats, field)
    once = {"tree", "light_tree"}  # fitted in the first frame alone
    assert stats.gpu_ms.keys() - {"mean"} - once == frame.stats.gpu_ms.keys() - once
    assert stats.cpu_ms > 0.0


@all_techniques
def test_drawing_reads_nothing_and_waits_for_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One submit, and one buffer of statistics that is asked for."""
    scene = stage.standard_scene(stage.light_for(name))
    calls: Counter[str] = Counter()
    within: list[str] = []

    def count(cls: type, method: str) -> None:
        original = getattr(cls, method)

        def counted(self: Any, *arguments: Any, **named: Any) -> Any:
            calls[method] += not within  # mapping a buffer submits nothing once more: its own business
            within.append(method)
            try:
                return original(self, *arguments, **named)
            finally:
                within.pop()

        monkeypatch.setattr(cls, method, counted)

    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        finished(renderer, renderer.draw(stage.CAMERA))
        for cls in (wgpu_native.GPUBuffer, wgpu_native.GPUQueue, wgpu_native.GPUDevice, wgpu_native.GPUPromise):
            for method in dir(cls):
                waits = method.endswith(("_sync", "_async", "_wait")) or method in ("read_buffer", "read_texture")
                if waits or method == "submit":
                    count(cls, method)
        with recording(acquire()) as record:
            renderer.draw(stage.CAMERA)
        assert calls == {"submit": 1, "map_async": 1}
        monkeypatch.undo()
        assert record.count("copy_texture_to_buffer") == 0
        staged = [arguments for method, arguments in record.commands if "read back" in arguments]
        assert staged
        assert all(method != "copy_texture_to_buffer" for method, _ in record.commands)
        assert renderer.passes is not None
        assert renderer.passes.ring.size <= RING * (SMALL + 1024)


def test_nothing_waits_where_more_frames_are_under_way_than_there_are_buffers() -> None:
    with ss.Renderer(stage.standard_scene(), technique=stage.cheap("hard"), size=stage.SIZE) as renderer:
        numbers = [renderer.draw(stage.CAMERA) for _ in range(4 * RING)]
        assert numbers == list(range(1, 4 * RING + 1))
        assert finished(renderer, RING).number <= numbers[-1]
        assert finished(renderer, renderer.draw(stage.CAMERA)).number == numbers[-1] + 1


def test_a_drawn_frame_without_its_completion_word_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    encode = Readback.encode

    def encode_and_lose_the_word(self: Any, encoder: Any) -> None:
        encode(self, encoder)
        encoder.clear_buffer(self._staging, self._size, 16)

    with ss.Renderer(stage.standard_scene(), technique=stage.cheap("hard"), size=stage.SIZE) as renderer:
        monkeypatch.setattr(Readback, "encode", encode_and_lose_the_word)
        number = renderer.draw(stage.CAMERA)
        with pytest.raises(ss.DeviceError, match="unfinished frame"):
            finished(renderer, number)
        monkeypatch.undo()
        assert finished(renderer, renderer.draw(stage.CAMERA)).number == number + 1


def test_drawing_refines_while_nothing_moves() -> None:
    """The third frame drawn is the third that `refine` gives; a moved camera begins again."""
    scene = stage.standard_scene()
    nearer = dataclasses.replace(stage.CAMERA, vertical_fov=30.0)
    with ss.Renderer(scene, technique=Uniform(grid=3, resolution=256), size=stage.SIZE) as renderer:
        refined = [renderer.refine(stage.CAMERA) for _ in range(3)]
        assert not stage.same_bits(refined[0].visibility, refined[2].visibility)
    with ss.Renderer(scene, technique=Uniform(grid=3, resolution=256), size=stage.SIZE) as renderer:
        for _ in range(3):
            renderer.draw(stage.CAMERA)
        assert same_images(on_gpu(renderer), refined[2])
        renderer.draw(nearer)
        assert same_images(on_gpu(renderer), renderer.render(nearer))
        renderer.draw(nearer)
        assert not same_images(on_gpu(renderer), renderer.render(nearer))


def test_the_mean_is_that_of_double_precision() -> None:
    """The mean of refined frames, against their frames one by one: a running mean in single precision."""
    technique, count = Uniform(grid=3, resolution=256), 40
    scene = stage.standard_scene()
    with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:
        frames = []
        for number in range(count):
            renderer.prepare()
            assert renderer.passes is not None
            renderer.passes.mean.forget()
            monkey = renderer.passes.groups.write
            renderer.passes.groups.write = lambda lights, _, n=number, write=monkey, **how: write(lights, n)  # type: ignore[method-assign]
            frames.append(renderer.render(stage.CAMERA))
            renderer.passes.groups.write = monkey  # type: ignore[method-assign]
        for _ in range(count):
            refined = renderer.refine(stage.CAMERA)
    for image in ("visibility", "color"):
        exact = np.mean([getattr(frame, image) for frame in frames], axis=0, dtype=np.float64)
        assert np.abs(getattr(refined, image) - exact).max() <= 4e-7 * max(exact.max(), 1.0)


def test_another_size_rebuilds_images_alone() -> None:
    scene, technique = stage.standard_scene(), stage.cheap("pcss")
    gpu = acquire()
    with ss.Renderer(scene, technique=technique, size=(33, 21)) as renderer:
        renderer.render(stage.CAMERA)
        renderer.draw(stage.CAMERA)  # under way while its buffers go
        compiled = len(gpu.pipelines)
        with recording(gpu) as record:
            renderer.resize(stage.SIZE)
            frame = renderer.render(stage.CAMERA)
        assert len(gpu.pipelines) == compiled
        assert record.writes
        assert "scene" not in {write[3] for write in record.writes}
        assert finished(renderer, renderer.draw(stage.CAMERA)).number == 4
    assert stage.same_bits(frame.visibility, stage.render(scene, technique).visibility)
    with pytest.raises(ss.OptionError, match="size"):
        renderer.resize((0, 4))


def test_the_colour_can_be_bound_as_a_texture() -> None:
    with ss.Renderer(stage.standard_scene(), technique="none", size=stage.SIZE) as renderer:
        for texture in (renderer.images.color, renderer.images.position, renderer.images.normal):
            assert texture.usage & wgpu.TextureUsage.TEXTURE_BINDING
            assert texture.size[:2] == stage.SIZE
        assert renderer.images.visibility.usage & wgpu.BufferUsage.STORAGE
