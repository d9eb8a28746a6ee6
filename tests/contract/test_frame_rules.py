"""The rules of a frame: one read-back, no wait, cuts by size alone, a checked completion word, fallbacks, errors."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
import wgpu

import softshadows as ss
import stage
from softshadows import renderer as renderer_module
from softshadows.gpu.device import Gpu, acquire
from softshadows.gpu.readback import Readback
from softshadows.techniques import TECHNIQUES
from softshadows.visibility.maps.shadow_maps import ShadowMaps

all_techniques = pytest.mark.parametrize("name", list(TECHNIQUES))


# -- Read-backs and waits ----------------------------------------------------------------------------------------------


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts calls that wait for the GPU, read from it, or submit to it."""
    counts: Counter[str] = Counter()
    within: list[str] = []

    def count(cls: type, method: str) -> None:
        original = getattr(cls, method)

        def counted(self: Any, *args: Any, **kwargs: Any) -> Any:
            counts[
                method
            ] += not within  # what such a call does by itself, as mapping submits nothing once more, is its own
            within.append(method)
            try:
                return original(self, *args, **kwargs)
            finally:
                within.pop()

        monkeypatch.setattr(cls, method, counted)

    for cls in {type(acquire().device), type(acquire().device.queue), type(acquire().adapter), *_buffer_classes()}:
        for method in dir(cls):
            waits = method.endswith(("_sync", "_async")) or method in ("read_buffer", "read_texture")
            if (waits or method == "submit") and callable(getattr(cls, method)):
                count(cls, method)
    return counts


def _buffer_classes() -> set[type]:
    return {type(acquire().device.create_buffer(size=16, usage=wgpu.BufferUsage.COPY_DST))}


@all_techniques
def test_a_frame_reads_back_once_and_waits_for_nothing_else(name: str, calls: Counter[str]) -> None:
    scene = stage.standard_scene(stage.light_for(name))
    with ss.Renderer(scene, technique=stage.cheap(name), size=stage.SIZE) as renderer:
        for _ in range(2):  # the first frame builds everything, the second reuses it
            calls.clear()
            frame = renderer.render(stage.CAMERA)
            assert calls.pop("map_sync") == 1
            assert calls.pop("submit") == frame.stats.submits == 1
            assert not +calls, f"calls that wait: {+calls}"


def test_the_counter_sees_a_wait(calls: Counter[str]) -> None:
    """The test above can fail."""
    device = acquire().device
    device.queue.read_buffer(device.create_buffer(size=16, usage=wgpu.BufferUsage.COPY_SRC))
    assert calls["read_buffer"] == 1


@pytest.mark.parametrize("name", ["hard", "uniform", "adaptive"])
def test_lights_are_written_only_where_something_changed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not for a camera; for a light, and for geometry, whose extent the maps' depth depends on. Then the picture is a
    new renderer's."""
    written: list[int] = []
    original = ShadowMaps.write

    def counted(self: ShadowMaps, *args: Any, **others: Any) -> None:
        written.append(1)
        original(self, *args, **others)

    monkeypatch.setattr(ShadowMaps, "write", counted)
    scene, technique = stage.standard_scene(), stage.cheap(name)
    above = ss.Camera((0.0, 4.0, 0.1), (0.0, 0.0, 0.0))
    with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:

        def check(camera: ss.Camera, *, writes: bool) -> None:
            written.clear()
            frame = renderer.render(camera)
            assert bool(written) == writes
            assert stage.same_bits(frame.visibility, stage.render(scene, technique, camera=camera).visibility)

        check(stage.CAMERA, writes=True)
        check(stage.CAMERA, writes=False)
        check(above, writes=False)
        scene.lights = [dataclasses.replace(stage.RECT)]  # equal
        check(above, writes=False)
        scene.lights = [dataclasses.replace(stage.RECT, width=1.5)]
        check(above, writes=True)
        scene.nodes[1] = stage.moved(scene.nodes[1], (0.0, 9.0, 0.0))
        check(above, writes=True)
        check(above, writes=False)
        scene.lights = [*scene.lights, stage.RECT]  # new passes
        check(above, writes=True)
        renderer.invalidate()
        check(above, writes=True)


def test_where_a_frame_is_cut_depends_on_sizes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slow device cuts; the cuts are the same whatever the camera sees and wherever light and occluders are."""
    monkeypatch.setattr("softshadows.gpu.commands.SUBMIT_MS", 0.02)
    monkeypatch.setattr("softshadows.visibility.maps.plan.SUBMIT_MS", 0.02)
    technique = ss.techniques.Uniform(grid=4, resolution=64)
    scene = stage.standard_scene()
    submits = set()
    cameras = [stage.CAMERA, ss.Camera((0.0, 9.0, 0.1), (0.0, 0.0, 0.0)), ss.Camera((0.0, 2.0, 0.0), (0.0, 9.0, 1.0))]
    with ss.Renderer(scene, technique=technique, size=stage.SIZE) as renderer:
        whole = stage.render(scene, technique)
        for camera in cameras:
            for position in [(0.4, 4.0, 0.3), (5.0, 0.5, 0.0)]:
                scene.lights = [dataclasses.replace(stage.RECT, position=position)]
                for height in (0.0, 0.7):
                    scene.nodes[1] = stage.moved(scene.nodes[1], (0.0, height, 0.0))
                    submits.add(renderer.render(camera).stats.submits)
    assert len(submits) == 1, submits
    assert submits.pop() > 3
    monkeypatch.undo()
    uncut = stage.render(stage.standard_scene(), technique)
    assert uncut.stats.submits == 1
    assert stage.same_bits(whole.visibility, uncut.visibility)


def test_a_frame_without_its_completion_word_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """As when a driver gives up on a job and hands back an empty buffer."""
    with ss.Renderer(stage.standard_scene(), technique=stage.cheap("hard"), size=stage.SIZE) as renderer:
        expected = renderer.render(stage.CAMERA)
        encode = Readback.encode

        def encode_and_lose_the_word(self: Any, encoder: Any) -> None:
            encode(self, encoder)
            encoder.clear_buffer(self._staging, self._size, 16)

        def encode_and_keep_the_last_word(self: Any, encoder: Any) -> None:
            encode(self, encoder)
            self._frame += 1

        for broken in (encode_and_lose_the_word, encode_and_keep_the_last_word):
            monkeypatch.setattr(Readback, "encode", broken)
            with pytest.raises(ss.DeviceError, match="unfinished frame"):
                renderer.render(stage.CAMERA)
        monkeypatch.undo()
        assert stage.same_bits(renderer.render(stage.CAMERA).visibility, expected.visibility)


# -- Memory ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("technique", "budget", "amount"),
    [
        (ss.techniques.Uniform(grid=3, resolution=1024), 1, "4 MiB"),
        (ss.techniques.Hard(resolution=16384), 512, "1024 MiB"),
        (ss.techniques.Vsm(resolution=8192), 512, "512 MiB"),
    ],
    ids=["memory budget", "resolution", "moments"],
)
def test_too_much_memory_is_refused_with_the_amount(technique: Any, budget: int, amount: str) -> None:
    """R28: the next normal frame is as before."""
    before = stage.render(stage.standard_scene(), stage.cheap("hard"))
    with pytest.raises(ss.DeviceError, match=amount) as error:
        ss.render(stage.standard_scene(), technique=technique, size=stage.SIZE, memory_budget=budget)
    assert "ower" in str(error.value)
    after = stage.render(stage.standard_scene(), stage.cheap("hard"))
    assert stage.same_bits(after.visibility, before.visibility)


def test_a_small_memory_budget_draws_in_batches_with_the_same_result() -> None:
    technique = ss.techniques.Uniform(grid=5, resolution=256)
    results = [
        ss.render(stage.standard_scene(), technique=technique, size=stage.SIZE, memory_budget=budget)
        for budget in (1, 512)
    ]
    assert results[0].stats.gpu_bytes < results[1].stats.gpu_bytes
    assert stage.same_bits(results[0].visibility, results[1].visibility)


@pytest.mark.parametrize("budget", [0, -1, 1.5, "512", True])
def test_a_memory_budget_is_a_whole_number_of_mebibytes(budget: Any) -> None:
    with pytest.raises(ss.OptionError, match="memory_budget"):
        ss.Renderer(stage.standard_scene(), memory_budget=budget)


# -- Statistics --------------------------------------------------------------------------------------------------------


@all_techniques
def test_stats_are_sensible(name: str) -> None:
    scene = stage.standard_scene()
    light = stage.light_for(name)
    stats = []
    for lights in ([light], [light, light]):
        scene.lights = lights
        frame = stage.render(scene, stage.cheap(name))
        stats.append(frame.stats)
        pixels = stage.SIZE[0] * stage.SIZE[1]
        assert frame.stats.gpu_bytes > 4 * (3 + 3 + len(lights)) * pixels
        assert frame.stats.cpu_ms > 0.0
        assert frame.stats.submits >= 1
        assert [text for text in frame.stats.warnings if not text.startswith(f"{name}: ")] == acquire().fallbacks
        if "timestamp-query" in acquire().features:
            assert {"gbuffer", "shading"} <= set(frame.stats.gpu_ms)
        assert all(0.0 <= ms < 60_000.0 for ms in frame.stats.gpu_ms.values())
    assert stats[1].shadow_maps == 2 * stats[0].shadow_maps
    assert stats[1].lookups_per_pixel == 2 * stats[0].lookups_per_pixel
    assert (stats[0].shadow_maps > 0) == (stats[0].lookups_per_pixel > 0)


def test_uniform_counts_the_papers_maps() -> None:
    frame = stage.render(stage.standard_scene(), ss.techniques.Uniform(grid=17, resolution=16), (8, 8))
    assert frame.stats.shadow_maps == 289
    assert frame.stats.lookups_per_pixel == 289


# -- Without optional features -----------------------------------------------------------------------------------------


@contextmanager
def without(feature: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Gpu]:
    """The same device, as if the adapter lacked the feature."""
    gpu = acquire()
    lesser = dataclasses.replace(gpu, features=gpu.features - {feature}, fallbacks=[f"{feature}: not there"])
    with monkeypatch.context() as patch:
        patch.setattr(renderer_module, "acquire", lambda profile: lesser)
        yield lesser


@all_techniques
@pytest.mark.parametrize("feature", ["clip-distances", "timestamp-query"])
def test_the_picture_does_not_depend_on_optional_features(
    name: str, feature: str, monkeypatch: pytest.MonkeyPatch, compare_visibility: Any
) -> None:
    """Also with alpha masks, which are drawn by shaders of their own, where the technique does not refuse them by name.

    Clipped triangles round depths otherwise.
    """
    scene = stage.standard_scene(stage.light_for(name))
    scene.nodes.append(leaf())
    if name == "penumbra_wedges":
        with pytest.raises(ss.OptionError, match="alpha-masked"):
            stage.render(scene, stage.cheap(name))
        scene.nodes.pop()
    expected = stage.render(scene, stage.cheap(name))
    with without(feature, monkeypatch):
        frame = stage.render(scene, stage.cheap(name))
    compare_visibility(frame.visibility[0], expected.visibility[0], limit=1e-4)
    np.testing.assert_allclose(frame.color, expected.color, rtol=1e-3, atol=1e-5)
    warnings = [text for text in frame.stats.warnings if not text.startswith(f"{name}: ")]
    assert warnings == [f"{feature}: not there"]
    if feature == "timestamp-query":
        assert frame.stats.gpu_ms == {}


def leaf() -> ss.Node:
    """A card with holes: a checkerboard of alpha 0 and 1."""
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[..., 3] = 255 * (np.indices((8, 8)).sum(axis=0) % 2)
    material = ss.Material(
        "leaf", base_color_texture=ss.Texture(pixels, nearest=True), alpha_cutoff=0.5, double_sided=True
    )
    corners = np.float32([(-1.5, 0.6, 0.6), (-1.5, 0.6, 1.4), (0.2, 0.9, 1.4), (0.2, 0.9, 0.6)])
    texcoords = np.float32([[(0, 0), (0, 1), (1, 1), (1, 0)]] * 2)
    mesh = ss.Mesh(corners, np.uint32([[0, 1, 2], [0, 2, 3]]), texcoords=texcoords, material=material)
    return ss.Node(mesh, name="leaf")


def test_triangles_without_a_plane_are_not_seen() -> None:
    """Corners on one line: the rasteriser snaps them to a pixel here and there, where no normal could be given."""
    random = np.random.default_rng(7)
    ends = random.uniform(-1.5, 1.5, (400, 2, 3)).astype(np.float32)
    ends = np.round(ends * 1024.0) / 1024.0  # so that the middle lies exactly between them
    middle = ends.mean(axis=1, keepdims=True)
    corners = np.concatenate([ends, middle], axis=1).reshape(-1, 3).astype(np.float32)
    lines = ss.Mesh(corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3), material=stage.MATT)
    scene = stage.standard_scene()
    expected = stage.render(scene, "none", (160, 120))
    scene.nodes.append(ss.Node(lines))
    frame = stage.render(scene, "none", (160, 120))
    assert np.allclose(np.linalg.norm(frame.normal[frame.surface], axis=-1), 1.0, atol=1e-5)
    assert np.array_equal(frame.position, expected.position)
