"""Variable penumbra against its paper's fidelity checks (papers.md 2.8): filters, bands, mask, reads, widths."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import softshadows as ss
import stage
from softshadows.gpu import layout
from softshadows.gpu.device import acquire
from softshadows.lights.sample_sets import Sampling, center_sample
from softshadows.techniques import Technique
from softshadows.techniques.base import RenderContext
from softshadows.techniques.light_pass import LightPass, Lookups, map_source
from softshadows.techniques.taps import taps
from softshadows.techniques.variable_penumbra import variable_penumbra
from softshadows.techniques.variable_penumbra.variable_penumbra import (
    Bands,
    Fixed,
    FromLight,
    VariablePenumbra,
    mip_level,
)
from softshadows.visibility.maps.shadow_maps import MapOptions
from softshadows.visibility.maps.structs import ShadowView

SIZE = (160, 120)
RESOLUTION = 256
DOWN = ss.DirectionalLight((0.0, -1.0, 0.0), stage.WHITE)
SLANTED = ss.DirectionalLight((-0.3, -1.0, -0.2), stage.WHITE)
POINT = stage.LIGHTS["point"]
BOX = stage.box((-0.6, 0.0, -0.5), (0.3, 1.1, 0.4))
FIXED, BANDS = Fixed(), Bands()
UNREACHED = 1000.0
"""A strength that no edge has."""
Combine = Callable[[RenderContext], Lookups]
make = partial(VariablePenumbra, resolution=RESOLUTION)


def frame_with_margin(
    scene: ss.Scene, technique: Technique, margin: int, combine: Combine, monkeypatch: Any
) -> ss.Frame:
    """A technique with the margin of another, so that both have the same map."""

    def build(self: Technique, context: RenderContext) -> LightPass:
        maps = map_source(context, RESOLUTION, MapOptions(margin_texels=margin))
        return LightPass(context, Sampling(center_sample, ignores_size=True), maps, combine(context))

    with monkeypatch.context() as patch:
        patch.setattr(type(technique), "build", build)
        return stage.render(scene, technique, SIZE)


def hard_frame(scene: ss.Scene, technique: VariablePenumbra, monkeypatch: pytest.MonkeyPatch) -> ss.Frame:
    """The hard shadow in the map that `technique` has."""
    average = partial(Lookups, shader="techniques/uniform/uniform.wgsl")
    return frame_with_margin(scene, ss.techniques.Hard(), margin_of(technique), average, monkeypatch)


def pcf_frame(scene: ss.Scene, kernel: int, margin: int, monkeypatch: pytest.MonkeyPatch) -> ss.Frame:
    """Plain PCF, everywhere, in a map with that margin."""
    pcf = ss.techniques.Pcf(kernel=kernel, pattern="poisson")
    return frame_with_margin(scene, pcf, margin, pcf.filtered, monkeypatch)


def margin_of(technique: VariablePenumbra) -> int:
    return 3 << mip_level(largest_kernel(technique)) - 1


def largest_kernel(technique: VariablePenumbra) -> int:
    """Taps along its side."""
    assert not isinstance(technique.kernels, FromLight)
    return technique.kernels.size if isinstance(technique.kernels, Fixed) else max(technique.kernels.sizes)


def as_if(strength: float) -> Bands:
    """Bands that take an edge of strength 1 for one of this strength."""
    return Bands(edges=tuple(edge / strength for edge in BANDS.edges))


def with_grids(monkeypatch: pytest.MonkeyPatch) -> None:
    """Taps in a square grid, whose averages over a straight edge are whole columns."""
    monkeypatch.setattr(variable_penumbra, "taps", lambda pattern, count: taps("grid", count))


def box_scene(light: Any) -> ss.Scene:
    return ss.Scene([stage.floor(), BOX], [light], stage.CAMERA)


def mask_of(scene: ss.Scene, technique: VariablePenumbra) -> np.ndarray:
    """The mask as the GPU left it, (cells, cells) uint32, for a map of RESOLUTION²."""
    with ss.Renderer(scene, technique=technique, size=SIZE) as renderer:
        renderer.render(stage.CAMERA)
        words = np.frombuffer(acquire().device.queue.read_buffer(renderer.passes.technique.combination._mask), "<u4")  # type: ignore[union-attr]
    side = round(len(words) ** 0.5)
    return words.reshape(side, side)


def texels_per_metre(renderer: ss.Renderer) -> float:
    """Texels along a metre of the only view of a map whose light shines straight down."""
    ((maps, _),) = renderer.passes.technique.by_light  # type: ignore[union-attr]
    data = bytes(acquire().device.queue.read_buffer(maps.views))  # type: ignore[arg-type]
    views = np.frombuffer(data, layout.dtype(ShadowView))
    return float(views["texels_per_unit"][0].min())


# -- Where there is no edge --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("neighbours", [4, 8])
@pytest.mark.parametrize("light", [DOWN, SLANTED, POINT, stage.LIGHTS["spot"]], ids=lambda light: light.kind)
def test_planes_have_no_edges(light: Any, neighbours: int) -> None:
    """Check 1: constant or linear depth answers nothing; elsewhere only where the plane ends, out of the picture."""
    scene = ss.Scene([], [light], ss.Camera((0.5, 3.0, 1.0), (0.0, 0.0, 0.0), 40.0))
    scene.nodes = [stage.quad([(-30, -3, -30), (-30, -3, 30), (30, 3, 30), (30, 3, -30)])]
    technique = make(kernels=FIXED, edge_filter=neighbours)
    if light.kind == "directional":
        assert not mask_of(scene, technique).any()
    frame = stage.render(scene, technique, SIZE)
    assert frame.stats.lookups_per_pixel == 2.0, "the mask and the map, once each"
    assert (frame.visibility[0][frame.facing[0]] == 1.0).all()


@pytest.mark.parametrize("kernels", [FIXED, Bands(edges=(UNREACHED,) * 3)], ids=["fixed", "bands"])
@pytest.mark.parametrize("light", [SLANTED, POINT], ids=lambda light: light.kind)
def test_an_empty_mask_is_the_hard_shadow(light: Any, kernels: Bands | Fixed, monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks 1 and 4: bit for bit."""
    monkeypatch.setattr(variable_penumbra, "EDGE_NOISE", UNREACHED)
    technique = make(kernels=kernels)
    frame = stage.render(box_scene(light), technique, SIZE)
    assert stage.same_bits(frame.visibility, hard_frame(box_scene(light), technique, monkeypatch).visibility)
    assert (frame.visibility[0] == 0.0).any()


def test_one_tap_outside_the_mask() -> None:
    """Check 4: a floor under a card that casts no shadow in view reads the mask and the map once each."""
    scene = ss.Scene([stage.floor(), stage.card(-0.5, 0.5, -0.5, 0.5, 1.0)], [POINT], stage.CAMERA)
    frame = stage.render(scene, make(kernels=Bands(edges=(UNREACHED,) * 3)), SIZE)
    assert frame.stats.lookups_per_pixel == 2.0


# -- Bands -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("neighbours", [4, 8])
@pytest.mark.parametrize(
    ("strength", "bands"),
    [(0.2, 0), (0.2001, 1), (0.5, 1), (0.5001, 2), (0.8, 2), (0.8001, 4)],
)
def test_bands_of_a_straight_edge(strength: float, bands: int, neighbours: int) -> None:
    """Checks 2 and 3: a step over the whole depth has strength 1, with either filter, and no more."""
    scene = ss.Scene([stage.floor(), stage.card(-9.0, 0.2, -9.0, 9.0, 1.0)], [DOWN], stage.CAMERA)
    found = mask_of(scene, make(kernels=as_if(strength), edge_filter=neighbours))
    assert set(np.unique(found)) == {0, bands}


def test_the_mask_reaches_as_far_as_the_mip_chain() -> None:
    """Check 7: the cells that a float mip chain, clamped and fetched bilinearly at native resolution, would set."""
    scene = ss.Scene([stage.floor(), stage.card(-9.0, 0.2, -9.0, 9.0, 1.0)], [DOWN], stage.CAMERA)
    for kernel, level in ((4, 2), (7, 3), (12, 4)):
        assert mip_level(kernel) == level
        finest = mask_of(scene, make(kernels=Fixed(size=2)))  # level 1: one texel to a cell
        coarse = mask_of(scene, make(kernels=Fixed(size=kernel)))
        columns = np.flatnonzero((coarse != 0).any(axis=0))
        width = len(columns) * 2 ** (level - 1)
        # The edge's texel of that level, and half a texel on each side.
        assert width == 2 * 2**level
        assert (finest != 0).any()


@pytest.mark.parametrize("kernel", [2, 3, 4, 5, 7])
@pytest.mark.parametrize("neighbours", [4, 8])
def test_masked_pcf_is_pcf_on_a_plane(kernel: int, neighbours: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks 5 and 6: without self-shadowing, the mask changes nothing on the floor, bit for bit."""
    technique = make(kernels=Fixed(size=kernel), edge_filter=neighbours, self_shadowing=False)
    for light in (SLANTED, POINT):
        frame = stage.render(box_scene(light), technique, SIZE)
        plain = pcf_frame(box_scene(light), kernel, margin_of(technique), monkeypatch)
        floor = frame.surface & (np.abs(frame.position[..., 1]) < 1e-4)
        assert np.array_equal(frame.visibility[0][floor], plain.visibility[0][floor])
        assert len(np.unique(frame.visibility[0][floor])) >= 4
        assert (frame.visibility[0][~floor] == 1.0).all(), "solids do not receive"
        assert frame.stats.lookups_per_pixel < 0.6 * kernel**2 + 2.0


@pytest.mark.parametrize(("strength", "kernel"), [(0.3, 3), (0.6, 5), (1.0, 7)])
def test_each_band_is_pcf_with_its_kernel(strength: float, kernel: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check 5 for the quantised mask: bit for bit, of an edge whose whole length is in one band."""
    scene = ss.Scene([stage.floor(), stage.card(-9.0, 0.2, -9.0, 9.0, 1.0)], [DOWN], stage.CAMERA)
    technique = make(kernels=as_if(strength))
    frame = stage.render(scene, technique, SIZE)
    plain = pcf_frame(scene, kernel, margin_of(technique), monkeypatch)
    floor = frame.surface & (np.abs(frame.position[..., 1]) < 1e-4)
    assert np.array_equal(frame.visibility[0][floor], plain.visibility[0][floor])
    assert len(np.unique(frame.visibility[0][floor])) >= 4


# -- Widths ------------------------------------------------------------------------------------------------------------


def test_width_takes_four_values_and_grows_with_height(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check 8: a half-plane under a light that shines straight down; a post of 2 m in view sets what the map spans."""
    with_grids(monkeypatch)
    post = stage.box((0.55, 0.0, 0.15), (0.6, 2.0, 0.2))
    widths = []
    for height in (0.2, 0.7, 0.95, 1.1, 1.5, 1.7, 1.9):
        scene = ss.Scene([stage.floor(), post, stage.card(-9.0, 0.3, -9.0, 9.0, height)], [DOWN])
        fov = 2.0 * np.degrees(np.arctan(0.3 / (0.9 * height)))
        camera = ss.Camera((0.3, 0.9 * height, 0.0), (0.3, 0.0, 0.0), fov, up=(0.0, 0.0, -1.0))
        frame = ss.render(scene, camera, technique=make(), size=(320, 240))
        row = frame.visibility[0][160]
        assert np.abs(frame.position[160, :, 1]).max() < 1e-4, "the row shows the floor"
        assert (np.diff(row) >= 0.0).all(), "from dark to light, without a jump back"
        shares = np.unique(row)
        widths.append(len(shares) - 1 if len(shares) > 2 else 0)
        assert np.allclose(shares, np.linspace(0.0, 1.0, len(shares)))
    assert widths == [0, 3, 3, 5, 5, 7, 7]


@pytest.mark.parametrize("preset", ["4x4", "7x7", "2/3/5", "3/5/7"])
def test_only_0_and_1_beyond_the_kernel(preset: str) -> None:
    """Check 9: farther than the largest kernel's radius and a texel from the edge of a half-plane's shadow."""
    scene = ss.Scene([stage.floor(), stage.card(-9.0, 0.3, -9.0, 9.0, 1.0)], [DOWN])
    camera = ss.Camera((0.3, 0.9, 0.0), (0.3, 0.0, 0.0), 37.0, up=(0.0, 0.0, -1.0))
    technique = VariablePenumbra.of({"preset": preset, "resolution": RESOLUTION})
    kernel = largest_kernel(technique)
    with ss.Renderer(scene, technique=technique, size=(320, 240)) as renderer:
        frame = renderer.render(camera)
        texel = 1.0 / texels_per_metre(renderer)
    away = np.abs(frame.position[..., 0] - 0.3) > (0.5 * kernel + 1.0) * texel
    assert set(np.unique(frame.visibility[0][away])) == {0.0, 1.0}
    assert ((frame.visibility[0] > 0.0) & (frame.visibility[0] < 1.0)).any()
    assert (frame.visibility[0][away] == (frame.position[..., 0][away] > 0.3)).all()


# -- Reads -------------------------------------------------------------------------------------------------------------


@cache
def reads_of(technique: VariablePenumbra) -> tuple[float, float]:
    """Reads per pixel of a frame of `mannequin`: by the picture's pixels, and by the map's texels before them."""
    size = (512, 384)
    frame = stage.render(ss.scenes.mannequin(), technique, size)
    texel_reads = (1 + 1 + technique.edge_filter) * int(technique.resolution) ** 2
    return frame.stats.lookups_per_pixel, texel_reads / (size[0] * size[1])


def preset(name: str, **options: Any) -> VariablePenumbra:
    return VariablePenumbra.of({"preset": name, "resolution": 512, **options})


def test_table_1_in_reads() -> None:
    """Check 10: hard > 2/3/5 > 3/5/7 > 7×7 > plain 4×4, in dependent reads per pixel; half of the suite's size.

    The mask of 4×4, fastest in the paper, comes after the bands: weak edges are in none of them and cost nothing.
    """
    four, seven, bands, wide_bands = (reads_of(preset(name))[0] for name in ("4x4", "7x7", "2/3/5", "3/5/7"))
    hard, plain = 1.0, 16.0
    assert hard < bands < wide_bands < seven < plain
    assert bands < four < seven
    assert four <= plain / 3.0


def test_tables_2_and_3_in_reads() -> None:
    """Check 10: maps of twice the side, and filter (2), read more; their cost is the map's texels, before any pixel."""
    usual = sum(reads_of(preset("2/3/5")))
    assert sum(reads_of(preset("2/3/5", resolution=256))) < usual < sum(reads_of(preset("2/3/5", resolution=1024)))
    assert usual < sum(reads_of(preset("2/3/5", edge_filter=8)))


# -- Two layers of the map ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bar_height", [1.4, 1.5, 1.9])
@pytest.mark.parametrize("bar_edge", [0.2935, 0.295])
def test_an_internal_edge_leaves_the_outlines_kernel_alone(
    bar_height: float, bar_edge: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """[Evans2014 §5] A slab 0.2 m over the floor whose edge is in no band, a bar above with its edge one to two texels
    from the slab's: another texel, yet near enough for every band's dilation but the weakest one's.

    The bar is wholly before the slab, so the floor's shadow is the slab's. One layer takes the bar's edge for the
    floor's and softens it; two give what the slab gives alone, bit for bit.
    """
    with_grids(monkeypatch)
    post = stage.box((0.55, 0.0, 0.15), (0.6, 2.0, 0.2))
    slab = stage.card(-9.0, 0.3, -9.0, 9.0, 0.2)
    bar = stage.card(-9.0, bar_edge, -9.0, 9.0, bar_height)
    camera = ss.Camera((0.3, 0.18, 0.0), (0.3, 0.0, 0.0), 118.0, up=(0.0, 0.0, -1.0))

    def row(nodes: list[ss.Node], layers: int) -> np.ndarray:
        scene = ss.Scene([stage.floor(), post, *nodes], [DOWN])
        technique = make(layers=layers)
        frame = ss.render(scene, camera, technique=technique, size=(320, 240))
        assert np.abs(frame.position[160, :, 1]).max() < 1e-4, "the row shows the floor"
        return frame.visibility[0][160]

    alone = row([slab], 1)
    assert set(np.unique(alone)) == {0.0, 1.0}
    assert stage.same_bits(row([slab, bar], 2), alone)
    assert len(np.unique(row([slab, bar], 1))) > 2, "the artefact"


def test_surfaces_before_the_last_keep_the_edges_before_them() -> None:
    """A card over a table over a floor: its shadow on the table is as soft with two layers as with one."""
    card = stage.card(-0.3, 0.2, -0.3, 0.3, 1.6)
    table = stage.card(-9.0, 9.0, -9.0, 9.0, 0.4)
    scene = ss.Scene([stage.floor(9.0), table, card], [SLANTED], stage.CAMERA)
    one, two = (stage.render(scene, make(layers=layers), SIZE).visibility for layers in (1, 2))
    assert stage.same_bits(one, two)
    assert len(np.unique(one)) > 4


@pytest.mark.parametrize("kernels", ["bands", "from_light"])
def test_nothing_changes_where_no_surface_is_between(kernels: str) -> None:
    """One card over a floor has no internal edge."""
    scene = ss.Scene([stage.floor(), stage.card(-0.6, 0.3, -0.5, 0.4, 1.1)], [stage.RECT], stage.CAMERA)
    one, two = (stage.render(scene, make(kernels=kernels, layers=layers), SIZE).visibility for layers in (1, 2))
    assert stage.same_bits(one, two)


@pytest.mark.parametrize("scene", ["figures", "leaves"])
def test_two_layers_bring_widths_from_the_light_nearer_the_truth(scene: str) -> None:
    """Edges of leaves over leaves no longer mix with those over the floor: rmse to 0.89 and 0.91 of what it was."""
    built = getattr(ss.scenes, scene)()
    frames = [
        stage.render(built, VariablePenumbra(kernels="from_light", layers=layers), (240, 180)) for layers in (1, 2)
    ]
    truth = ss.truth.visibility(built, frames[0], samples=128)
    mask = frames[0].surface & frames[0].facing[0]
    one, two = (ss.metrics.compare(frame.visibility[0], truth[0], mask=mask).rmse for frame in frames)
    assert two < 0.95 * one


# -- Kernels from the light --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [1.0, 2.5, 4.0])
def test_width_from_the_light_on_o1(height: float) -> None:
    """The exact penumbra to 20 % (the issue's bar; 10 % is its aim), where the bands are off by most of it."""
    exact = 2.0 * 1.0 * height / (10.0 - height)
    middle = 0.3 * 10.0 / (10.0 - height)
    scene = ss.scenes.blocker(light_height=10.0, height=height, occluders=[(-60.0, 0.3, -60.0, 60.0)], floor_half=8.0)
    fov = 2.0 * np.degrees(np.arctan(1.5 * exact / (0.9 * height)))
    camera = ss.Camera((middle, 0.9 * height, 0.0), (middle, 0.0, 0.0), fov, up=(0.002, 0.0, -1.0))

    @cache
    def error(kernels: str) -> float:
        technique = VariablePenumbra(kernels=kernels)
        frame = ss.render(scene, camera, technique=technique, size=(160, 120))
        x = frame.position[60, :, 0]
        width = ss.metrics.penumbra_width(frame.visibility[0][60], float(np.diff(x).mean()))
        return float(width / 0.8 / exact - 1.0)

    assert abs(error("from_light")) <= 0.1
    assert error("bands") < -0.5, "the paper's kernels do not know the light"


def test_kernels_from_a_light_without_size_are_hard() -> None:
    scene = stage.standard_scene(ss.RectLight(stage.RECT.position, stage.RECT.target, 0.0, 0.0, stage.WHITE))
    frame = stage.render(scene, make(kernels="from_light"), SIZE)
    assert set(np.unique(frame.visibility)) == {0.0, 1.0}
    assert frame.stats.lookups_per_pixel < 6.0


def test_presets_are_the_papers_versions() -> None:
    assert VariablePenumbra.preset("3/5/7") == VariablePenumbra()
    assert VariablePenumbra.preset("4x4") == VariablePenumbra(kernels=Fixed(size=4))
    assert VariablePenumbra.preset("paper") == VariablePenumbra(self_shadowing=False)
    with pytest.raises(ss.OptionError, match="2/3/5"):
        VariablePenumbra.preset("9x9")
