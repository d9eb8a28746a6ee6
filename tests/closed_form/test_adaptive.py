"""Adaptive light sampling: the fidelity checks of the paper (numbered as in the tests' texts), and what this one adds.

Two witnesses: closed forms in scene O1 (a half-plane over a floor, seen straight from above, the edge parallel to the
light's, so that each light sample's shadow ends in a column of the picture), and a second implementation of the trees
(adaptive_model.py) that starts from the look-ups the GPU remembers.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import re
from collections import Counter
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import wgpu

import adaptive_model as model
import softshadows as ss
import stage
from softshadows.gpu.device import acquire
from softshadows.techniques import Adaptive, Uniform
from softshadows.truth import closed_form

H, h, e = 10.0, 4.0, 0.3
FAR = 60.0
PIXEL = 0.04  # metres on the floor of O1
SIZE = (64, 36)
WHITE = (1.0, 1.0, 1.0)
FINE = 512  # texels along a map: eight along a pixel of O1
COARSE = 128
STANDARD, FLOOR = stage.standard_scene(), ss.scenes.blocker(occluders=[]).nodes
SMALL_CARD = stage.card(-0.5, 0.5, -0.5, 0.5, 3.0)
ODD_SIZE = (61, 45)

both_refinements = pytest.mark.parametrize("refinement", ["global", "tile"])
both_weights = pytest.mark.parametrize("weights", ["area", "paper"])
UNIFORM_WEIGHTS = {"area": "trapezoid", "paper": "equal"}


# -- Scenes and frames -------------------------------------------------------------------------------------------------


def half_width(pixels: float) -> float:
    """The light's half width for which the penumbra of O1 is `pixels` wide."""
    return pixels * PIXEL * (H - h) / (2.0 * h)


def o1(pixels: float, *, is_line: bool = False) -> ss.Scene:
    """O1 with a penumbra `pixels` wide, where a pixel is PIXEL."""
    a = half_width(pixels)
    light: Any = ss.RectLight((0.0, H, 0.0), (0.0, 0.0, 0.0), 2.0 * a, 1.2, WHITE)
    if is_line:
        light = ss.LineLight((-a, H, 0.0), (a, H, 0.0), WHITE)
    return ss.Scene(_o1_nodes(), [light])


@functools.cache
def _o1_nodes() -> list[ss.Node]:
    return ss.scenes.blocker(height=h, occluders=[(-FAR, e, -FAR, FAR)], floor_half=FAR / 2.0).nodes


def standard(*lights: Any) -> ss.Scene:
    return ss.Scene(STANDARD.nodes, list(lights))


def above(
    eye: float = 3.5, x: float = e * H / (H - h), pixel: float = PIXEL, size: tuple[int, int] = SIZE
) -> ss.Camera:
    """Straight down from `eye` above the middle of O1's penumbra; a pixel is `pixel` metres wide."""
    fov = 2.0 * np.degrees(np.arctan(0.5 * size[1] * pixel / eye))
    return ss.Camera((x, eye, 0.0), (x, 0.0, 0.0), float(fov), up=(0.0, 0.0, -1.0))


_kept: dict[tuple, ss.Renderer] = {}


def _renderer(made: ss.Scene, size: tuple[int, int], options: dict[str, Any]) -> ss.Renderer:
    """The last one, where only lights differ: it takes longer to build than to use."""
    key = (size, *(id(node.mesh) for node in made.nodes), *sorted(options.items()))
    if key not in _kept:
        _kept.clear()
        budget = {name: value for name, value in options.items() if name == "memory_budget"}
        own = {name: value for name, value in options.items() if name not in budget}
        _kept[key] = ss.Renderer(made, technique=Adaptive(**own), size=size, **budget)
    _kept[key].scene = made
    return _kept[key]


def frame_of(made: ss.Scene, camera: ss.Camera | None = None, size: tuple[int, int] = SIZE, **options: Any) -> ss.Frame:
    options = {"refinement": "global", "resolution": COARSE, **options}
    return _renderer(made, size, options).render(camera or above())


def depth_of(frame: ss.Frame, dimensions: int = 2) -> int:
    """The depth of a uniform tree, by its number of maps."""
    depths = {(2**depth + 1) ** dimensions: depth for depth in range(5)}
    return depths[frame.stats.shadow_maps]


def capped_tiles(frame: ss.Frame) -> int:
    """By the frame's warning; 0 without one. It names all tiles of the picture, too."""
    height, width = frame.surface.shape
    for warning in frame.stats.warnings:
        pattern = rf"adaptive: max_depth=\d leaves bands in (\d+) of (\d+) tiles of {model.TILE}×{model.TILE} pixels"
        if found := re.fullmatch(pattern, warning):
            assert int(found[2]) == -(-height // model.TILE) * -(-width // model.TILE)
            assert int(found[1]) > 0
            return int(found[1])
    return 0


def grown(
    made: ss.Scene, camera: ss.Camera, size: tuple[int, int] = ODD_SIZE, **options: Any
) -> tuple[ss.Frame, model.Gpu, model.Tree]:
    """A frame, what the GPU's buffers hold after it, and the trees that the model grows from the look-ups in them."""
    options = {"refinement": "global", "resolution": 256, **options}
    renderer = _renderer(made, size, options)
    frame = renderer.render(camera)
    gpu = model.Gpu(renderer, frame, options["refinement"] == "global")
    step = round(1.0 / options.get("comparison_scale", 1.0))
    return frame, gpu, model.grow(gpu, step, options.get("threshold", 0))


def check_model(frame: ss.Frame, gpu: model.Gpu, tree: model.Tree, weights: str = "area") -> None:
    """The GPU's trees, requests, statistics and visibility are the model's."""
    assert not gpu.tree().same_as(tree)
    np.testing.assert_array_equal(gpu.requested, model.requested(gpu.lattice, tree))
    assert frame.stats.shadow_maps == model.maps(gpu, tree)
    assert frame.stats.lookups_per_pixel == pytest.approx(model.lookups(gpu, tree) / frame.surface.size, rel=1e-12)
    assert capped_tiles(frame) == tree.capped.sum()
    assert len(frame.stats.warnings) == int(tree.capped.any())
    expected = model.visibility(gpu, tree, weights)
    known = np.isfinite(expected)
    assert np.abs(frame.visibility[0] - expected)[known].max() < 1e-6
    assert np.isin(frame.visibility[0][~known], (0.0, 1.0)).all()


# -- The fidelity checks -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("is_line", "counts"), [(False, (4, 9, 25, 81, 289)), (True, (2, 3, 5, 9, 17))])
def test_full_refinement_takes_the_papers_maps(is_line: bool, counts: tuple[int, ...]) -> None:
    """1, and 3's first half: maps are shared. A penumbra so wide that every cell fails at every level."""
    for depth, count in enumerate(counts):
        frame = frame_of(o1(60.0, is_line=is_line), max_depth=depth)
        assert frame.stats.shadow_maps == count


@both_refinements
@both_weights
def test_weights_sum_to_one(refinement: str, weights: str) -> None:
    """2: what sees all of the light has exactly 1, what sees nothing of it exactly 0, under trees of mixed depth."""
    frame, gpu, tree = grown(STANDARD, stage.CAMERA, refinement=refinement, weights=weights)
    sums = model.weights(gpu.lattice, tree, weights).sum(axis=(2, 3))
    has_tree = tree.present[0, 0, 0]
    np.testing.assert_allclose(sums[has_tree], 1.0, rtol=1e-12)
    depths = {level for level, _, _ in (cell for cell, tiles in tree.present.items() if tiles.any())}
    assert len(depths) > 2, "the tree is too simple to show anything"
    requested = model.requested(gpu.lattice, tree).repeat(model.TILE, 0).repeat(model.TILE, 1)
    requested = requested[: gpu.surface.shape[0], : gpu.surface.shape[1]] & gpu.surface[:, :, None, None]
    some = requested.any(axis=(2, 3))
    all_visible = some & (gpu.visible | ~requested).all(axis=(2, 3))
    none_visible = some & ~(gpu.visible & requested).any(axis=(2, 3))
    assert all_visible.any()
    assert none_visible.any()
    assert (frame.visibility[0][all_visible] == 1.0).all()
    assert (frame.visibility[0][none_visible] == 0.0).all()


def test_one_corner_child_subdivided_takes_fourteen_maps() -> None:
    """3: 4 + 5 + 5. All pixels see the light cut by the corner of a quarter-plane, within the same quadrant."""
    light = ss.RectLight((0.0, H, 0.0), (0.0, 0.0, 0.0), 2.0, 2.0, WHITE)
    made = ss.scenes.blocker(light_height=H, height=h, occluders=[(-FAR, 0.0, -FAR, 0.0)], light=light)
    # The corner appears on the light at −(H − h) / h times the receiver's position: at −0.375 ± 0.15 in x and z.
    camera = ss.Camera((0.25, 3.5, 0.25), (0.25, 0.0, 0.25), float(np.degrees(2.0 * np.arctan(0.1 / 3.5))), (0, 0, -1))
    frame, gpu, tree = grown(made, camera, (24, 24), max_depth=2)
    assert frame.stats.shadow_maps == 14
    refined = [cell for cell, tiles in tree.refined.items() if tiles.any()]
    assert len(refined) == 2
    assert [level for level, _, _ in sorted(refined)] == [0, 1]
    check_model(frame, gpu, tree)


def crumbs() -> ss.Scene:
    """Scraps of floor a few pixels wide over nothing, in penumbrae of many widths: silhouettes everywhere, and with
    this seed a texel that depends on whether a neighbour counts whose tile does not have the cell."""
    random = np.random.default_rng(37)
    nodes = [stage.card(-0.9, 0.2, -0.7, 0.45, 1.1), stage.card(0.3, 0.8, -0.2, 1.2, 0.5)]
    for x, z in random.uniform(-1.8, 1.8, (120, 2)):
        half, height = random.uniform(0.01, 0.12), random.uniform(0.0, 0.3)
        nodes.append(stage.moved(stage.floor(half), (x, height, z)))
    return ss.Scene(nodes, [dataclasses.replace(stage.RECT, width=2.0, height=1.2)])


SCENES: dict[str, tuple[ss.Scene, ss.Camera]] = {
    "standard": (STANDARD, stage.CAMERA),
    "line": (standard(stage.LIGHTS["line"]), stage.CAMERA),
    "from near": (STANDARD, ss.Camera((0.6, 0.9, 1.6), (-0.1, 0.0, 0.2), 60.0)),
    "over the edge": (STANDARD, ss.Camera((2.5, 1.6, 3.5), (0.2, 0.9, 0.0), 70.0)),
    "large light": (standard(dataclasses.replace(stage.RECT, width=3.0, height=2.0)), stage.CAMERA),
    "flat rectangle": (standard(dataclasses.replace(stage.RECT, width=0.0)), stage.CAMERA),
    "no size": (standard(dataclasses.replace(stage.RECT, width=0.0, height=0.0)), stage.CAMERA),
    "o1": (o1(22.0), above()),
    "crumbs": (crumbs(), ss.Camera((1.0, 1.6, 1.5), (0.1, 0.0, 0.0), 60.0)),
}


@pytest.mark.parametrize("name", list(SCENES))
@both_refinements
def test_the_trees_are_the_models(name: str, refinement: str) -> None:
    """4, and 3 at every level: only texels that see 1 to 3 of a cell's corners fail, if no neighbour sees another
    number; in tile mode, as far as the tiles know the cell. There the root is always refined, and all such texels fail
    on the sure levels, also for tiles within half a tile around."""
    made, camera = SCENES[name]
    check_model(*grown(made, camera, refinement=refinement))


@both_refinements
@pytest.mark.parametrize("options", [
    {"comparison_scale": 0.5, "weights": "paper"}, {"comparison_scale": 0.25, "memory_budget": 1}, {"max_depth": 2},
    {"resolution": "auto", "memory_budget": 1}, {"max_depth": 1}, {"max_depth": 0},
    {"threshold": 1}, {"threshold": 12, "comparison_scale": 0.5}, {"threshold": 100, "weights": "paper"},
    {"weights": "paper"}, {"threshold": 20, "memory_budget": 1},
], ids=str)  # fmt: skip
def test_the_trees_are_the_models_with_every_option(options: dict[str, Any], refinement: str) -> None:
    """4 again."""
    made, camera = SCENES["large light"]
    frame, gpu, tree = grown(made, camera, refinement=refinement, **options)
    check_model(frame, gpu, tree, options.get("weights", "area"))


@pytest.mark.parametrize("size", [(1, 1), (17, 15), (3, 50)], ids=str)
def test_the_trees_are_the_models_at_any_size(size: tuple[int, int]) -> None:
    """4 at the image's borders, where tiles, boxes and rings are cut off."""
    for refinement in ("global", "tile"):
        check_model(*grown(*SCENES["o1"], size, refinement=refinement))


def band_depth(pixels: float, frame: ss.Frame, deepest: int = 4) -> int:
    """The depth at which no band of O1 is three columns wide, by the closed form; deepest + 1 where none is enough."""
    a, x = half_width(pixels), frame.position[0, :, 0].astype(np.float64)
    for depth in range(deepest + 1):
        samples = np.linspace(-a, a, 2**depth + 1)
        on_light = (e * H - x * (H - h)) / h  # the edge, seen from x
        visible = samples[None, :] > on_light[:, None]
        bands = visible.sum(axis=1)
        columns = [np.count_nonzero(bands == number) for number in range(1, 2**depth + 1)]
        if max(columns) <= 2:
            return depth
    return deepest + 1


@pytest.mark.parametrize(
    ("pixels", "depth"),
    [
        (1.9, 0),
        (3.1, 1),
        (3.8, 1),
        (6.2, 2),
        (7.7, 2),
        (12.4, 3),
        (15.5, 3),
        (24.4, 4),
        (31.0, 4),
        (36.0, 5),
        (50.0, 5),
    ],
)
def test_band_rule(pixels: float, depth: int) -> None:
    """5: a penumbra W pixels wide needs depth max(0, ceil(log2(W / 2))); more than there is, and the frame says so."""
    assert depth == max(0, int(np.ceil(np.log2(pixels / 2.0))))
    frame = frame_of(o1(pixels), resolution=FINE)
    assert band_depth(pixels, frame) == depth
    assert depth_of(frame) == min(depth, 4)
    assert (capped_tiles(frame) > 0) == (depth > 4)


@pytest.mark.parametrize("max_depth", [0, 1, 3])
def test_a_cap_that_is_reached_is_reported(max_depth: int) -> None:
    """5 for lower caps: a band just narrow enough at that depth, and one that is not."""
    enough, too_wide = (
        frame_of(o1(width * 2**max_depth), max_depth=max_depth, resolution=FINE) for width in (1.9, 3.1)
    )
    assert not enough.stats.warnings
    assert capped_tiles(too_wide) > 0


@pytest.mark.parametrize(("refinement", "most"), [("global", 4), ("tile", 0)])
def test_without_penumbra_there_is_no_refinement(refinement: str, most: int) -> None:
    """6: no occluder; a camera that sees only light; one that sees the sky."""
    empty, small = standard(stage.RECT), standard(stage.RECT)
    empty.nodes, small.nodes = FLOOR, [*FLOOR, SMALL_CARD]
    away, sky = ss.Camera((0.0, 2.0, 0.0), (20.0, 0.0, 3.0), 20.0), ss.Camera((0.0, 2.0, 0.0), (0.0, 3.0, 3.0), 30.0)
    for made, camera, maps in [(empty, above(), most), (small, away, most), (small, sky, 0)]:
        frame = frame_of(made, camera, refinement=refinement)
        assert frame.stats.shadow_maps == maps
        assert (frame.visibility == 1.0).all()
        assert not frame.stats.warnings


def test_twice_as_far_takes_one_level_less() -> None:
    """7: the penumbra of O1 is then half as many pixels wide."""
    made = o1(12.2)
    near, far = (frame_of(made, above(eye, pixel=PIXEL * eye / 1.75), resolution=FINE) for eye in (1.75, 3.5))
    assert (depth_of(near), depth_of(far)) == (3, 2)
    assert np.ptp(far.position[..., 0]) == pytest.approx(2.0 * np.ptp(near.position[..., 0]), rel=1e-3)


@both_weights
@pytest.mark.parametrize("is_line", [False, True], ids=["rect", "line"])
def test_fully_refined_is_uniform_sampling_to_the_bit(is_line: bool, weights: str) -> None:
    """8: the same maps in the same atlas, the same weights."""
    made = o1(60.0, is_line=is_line)
    frame = frame_of(made, weights=weights)
    assert depth_of(frame, 1 if is_line else 2) == 4
    uniform = Uniform(grid=17, weights=UNIFORM_WEIGHTS[weights], resolution=COARSE)
    expected = ss.render(made, above(), technique=uniform, size=SIZE)
    assert stage.same_bits(frame.visibility, expected.visibility)


@pytest.mark.parametrize(("weights", "limit", "least"), [("paper", 0.06, 0.045), ("area", 0.035, 0.02)])
def test_known_bias_of_a_closed_grid(weights: str, limit: float, least: float, compare_visibility: Any) -> None:
    """11: equal weights count the light's border too much: by 1/17 on O1, where the trapezoid rule errs by 1/32."""
    frame = frame_of(o1(50.0), weights=weights, resolution=FINE)
    assert depth_of(frame) == 4
    expected = closed_form.half_plane(frame.position[..., 0].astype(np.float64), H, h, half_width(50.0), e)
    compare_visibility(frame.visibility[0], expected, limit=limit)
    assert np.abs(frame.visibility[0] - expected).max() > least


@pytest.mark.parametrize("max_depth", range(5))
@pytest.mark.parametrize(("refinement", "weights"), [("global", "paper"), ("tile", "area")])
def test_umbra_and_full_light_are_exact(max_depth: int, refinement: str, weights: str) -> None:
    """12: exactly 0 and exactly 1, at every depth, but for a pixel beside the penumbra."""
    frame = frame_of(o1(36.0), max_depth=max_depth, refinement=refinement, weights=weights)
    for value in (0.0, 1.0):
        apart = (exact(36.0, frame, -PIXEL) == value) & (exact(36.0, frame, PIXEL) == value)
        assert np.count_nonzero(apart) > 0.1 * apart.size
        assert (frame.visibility[0][apart] == value).all()


def exact(pixels: float, frame: ss.Frame, shift: float = 0.0) -> npt.NDArray[np.float64]:
    return closed_form.half_plane(frame.position[..., 0].astype(np.float64) + shift, H, h, half_width(pixels), e)


@both_refinements
def test_a_smaller_comparison_never_takes_more_maps(refinement: str) -> None:
    """13, the part about resolution."""
    maps, lookups = [], []
    for scale in (1.0, 0.5, 0.25):
        frames = [
            frame_of(*SCENES[name], ODD_SIZE, refinement=refinement, comparison_scale=scale)
            for name in ("standard", "from near", "large light")
        ]
        maps.append([frame.stats.shadow_maps for frame in frames])
        lookups.append([frame.stats.lookups_per_pixel for frame in frames])
    for counts in (maps, lookups):
        assert (np.diff(counts, axis=0) <= 0).all(), counts
        assert counts[-1][0] < counts[0][0]


THRESHOLDS = (0, 1, 4, 16, 64, 256, 1 << 24)


@pytest.mark.parametrize("name", ["standard", "large light", "crumbs", "line"])
@both_refinements
def test_a_higher_threshold_never_takes_more_maps(name: str, refinement: str) -> None:
    """13, the part about the threshold. One tree for the picture only ever loses cells; in tiles, a cell that a
    neighbour lost may fail where it did not, so there only the sums are compared."""
    trees, maps, lookups = [], [], []
    for threshold in THRESHOLDS:
        frame, gpu, tree = grown(*SCENES[name], refinement=refinement, threshold=threshold)
        check_model(frame, gpu, tree)
        trees.append(tree)
        maps.append(frame.stats.shadow_maps)
        lookups.append(frame.stats.lookups_per_pixel)
    for counts in (maps, lookups):
        assert (np.diff(counts) <= 0).all(), counts
        assert counts[-1] < counts[0], counts
    if refinement == "global":
        for more, fewer in itertools.pairwise(trees):
            for cell, tiles in fewer.present.items():
                assert (tiles <= more.present[cell]).all()
    assert trees[-1].depth() == (1 if refinement == "tile" else 0)


# -- Beyond the paper --------------------------------------------------------------------------------------------------


def test_trees_by_tile_take_fewer_lookups() -> None:
    """The picture's one deep penumbra does not refine the rest of it: 0.243 of the look-ups here (0.152 when trees
    began with four samples and had two sure levels). It must be deep, as trees by tile refine the first three levels
    wherever there is a penumbra."""
    made = ss.scenes.sphere_cube()
    tile, whole = (
        frame_of(made, made.camera, (160, 120), refinement=refinement, resolution=256)
        for refinement in ("tile", "global")
    )
    assert tile.stats.lookups_per_pixel < 0.25 * whole.stats.lookups_per_pixel


@pytest.mark.parametrize("options", [{}, {"refinement": "global"}, {"threshold": 10}], ids=str)
def test_a_full_hd_picture_fits_the_default_memory(options: dict[str, Any]) -> None:
    """Ten words of 32 bits for each pixel's look-ups, in buffers as large as every WebGPU adapter has them."""
    with ss.Renderer(STANDARD, technique=Adaptive(**options), size=(1920, 1080)) as renderer:
        renderer.prepare()
        renderer.passes.technique.write(dict(enumerate(STANDARD.lights)))
        ((sampling, _),) = renderer.passes.technique._by_light  # type: ignore[union-attr]
        sizes = {name: buffer.size for name, buffer in vars(sampling.buffers).items()}
        tiles = -(-1920 // model.TILE) * -(-1080 // model.TILE)
        assert sizes["visibility_bits"] == tiles * model.TILE**2 * 40
        assert max(sizes.values()) <= 128 << 20, sizes  # WebGPU's default maxStorageBufferBindingSize


def test_a_full_hd_frame() -> None:
    """More tiles than one dimension of a dispatch takes for a list: 32400."""
    size = (1920, 1080)
    frame, gpu, tree = grown(STANDARD, stage.CAMERA, size, refinement="tile", max_depth=1)
    _kept.clear()
    stage.check_visibility(frame)
    check_model(frame, gpu, tree)
    assert frame.stats.shadow_maps == 9


def test_tiles_without_a_tree_are_exact() -> None:
    """Where a tile asks for no maps, uniform sampling finds all or nothing of the light, too."""
    for made, camera in (SCENES["standard"], SCENES["over the edge"]):
        frame, gpu, tree = grown(made, camera, refinement="tile")
        idle = model.by_pixel(~tree.present[0, 0, 0], gpu.surface.shape) & gpu.surface
        assert idle.any()
        expected = ss.render(made, camera, technique=Uniform(grid=5, resolution=256), size=ODD_SIZE)
        np.testing.assert_array_equal(frame.visibility[0][idle], expected.visibility[0][idle])


@both_refinements
def test_lights_of_all_shapes_share_a_scene(refinement: str) -> None:
    """Two rectangles are interleaved in the same buffers, others have their own: each as if it were alone."""
    point = dataclasses.replace(stage.RECT, width=0.0, height=0.0)
    other = dataclasses.replace(stage.RECT, position=(-1.5, 3.0, 1.0), width=2.0)
    lights = [stage.RECT, stage.LIGHTS["line"], point, other]
    together = frame_of(standard(*lights), stage.CAMERA, ODD_SIZE, refinement=refinement)
    alone = [frame_of(standard(light), stage.CAMERA, ODD_SIZE, refinement=refinement) for light in lights]
    for layer, frame in enumerate(alone):
        assert stage.same_bits(together.visibility[layer], frame.visibility[0])
    assert together.stats.shadow_maps == sum(frame.stats.shadow_maps for frame in alone)
    lookups = sum(frame.stats.lookups_per_pixel for frame in alone)
    assert together.stats.lookups_per_pixel == pytest.approx(lookups, rel=1e-12)
    assert set(np.unique(together.visibility[2])) == {0.0, 1.0}


@both_refinements
def test_a_frame_leaves_nothing_behind(refinement: str) -> None:
    """Camera and light move between frames, from deep trees to none and back: each as by a new renderer."""
    options: dict[str, Any] = {"refinement": refinement, "resolution": COARSE}
    near, sky = SCENES["from near"][1], ss.Camera((0.0, 2.0, 0.0), (0.0, 9.0, 3.0))
    wide = dataclasses.replace(stage.RECT, width=3.0)
    with ss.Renderer(standard(wide), technique=Adaptive(**options), size=ODD_SIZE) as renderer:
        for light, camera in [(wide, near), (stage.RECT, sky), (stage.RECT, stage.CAMERA), (wide, stage.CAMERA)]:
            renderer.scene.lights = [light]
            frame = renderer.render(camera)
            fresh = ss.render(standard(light), camera, technique=Adaptive(**options), size=ODD_SIZE)
            assert stage.same_bits(frame.visibility, fresh.visibility)
            assert frame.stats.shadow_maps == fresh.stats.shadow_maps
            assert frame.stats.lookups_per_pixel == fresh.stats.lookups_per_pixel


def test_nothing_waits_within_a_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """One read-back after one submit also with the paper's tree and many draws (the defaults: test_frame_rules.py)."""
    counts: Counter[str] = Counter()
    device = acquire().device
    buffer = type(device.create_buffer(size=16, usage=wgpu.BufferUsage.COPY_DST))

    def count(cls: type, method: str) -> None:
        original = getattr(cls, method)

        def counted(self: Any, *args: Any, **kwargs: Any) -> Any:
            counts[method] += 1
            return original(self, *args, **kwargs)

        monkeypatch.setattr(cls, method, counted)

    for cls, method in [(buffer, "map_sync"), (type(device.queue), "read_buffer"), (type(device.queue), "read_texture"),
                        (type(device.queue), "on_submitted_work_done_sync")]:  # fmt: skip
        count(cls, method)
    made, camera = SCENES["large light"]
    technique = Adaptive(refinement="global", resolution=256)
    with ss.Renderer(made, technique=technique, size=ODD_SIZE, memory_budget=1) as renderer:
        for _ in range(2):
            counts.clear()
            frame = renderer.render(camera)
            assert +counts == Counter(map_sync=1)
            assert frame.stats.submits == 1
