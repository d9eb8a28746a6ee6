"""Time and memory of the main techniques over pixels, light samples, triangles and lights.

One thing grows at a time, from what the others have in common: `figures`, 256×192 pixels, one light.

pixels          `figures` with 128×96 to 512×384 pixels
light samples   `figures` with 4 to 289 maps (`uniform`), and with ever deeper refinement (`adaptive`)
triangles       `sphere_cube` with 1 to 64 spheres: 764 to 48 770 triangles
hills           a terrain of 10³ to 10⁶ triangles, without maps
lights          `figures` with 1 to 4 rectangles that share the power of one, and with 64 where the technique is meant
                for it
light size      `figures` with its rectangle 1/4 to 4 times as wide and high

Lights move by a micrometre before every timed frame, so that nothing is kept from the last one, and techniques are
interleaved. A picture's figures: `axis`, the name of what grows. A technique's: `amount`, how much of it there is (for
light samples the number of maps), and `series`, which figures belong to one curve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from softshadows.bench.tree_times import OVER_HILLS, SUN, terrain
from softshadows.compare.interleaved import label_of, render_interleaved
from softshadows.compare.measure import Measurement, Notice, Result, measure_each, reference_frame
from softshadows.scene import builtin
from softshadows.scene.lights import RectLight
from softshadows.scene.model import Scene
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique, make_technique

if TYPE_CHECKING:
    from softshadows.bench.suites import Settings

SIZE = (256, 192)
SHARES = (0.5, 1.0, 2.0)
"""Factors on the size's width and height."""
GRIDS, DEPTHS = (2, 3, 5, 9, 17), (1, 2, 3, 4)
SPHERES = (1, 2, 4)
"""Along each side of the cube."""
HILLS = (1_000, 10_000, 100_000, 1_000_000)
"""Triangles."""
LIGHTS, MANY_LIGHTS = (1, 2, 4), (8, 64)
LIGHT_SPACING, LIGHT_ROW = 0.5, 3.5
"""Metres between the centres of several lights, and at most from the first to the last."""
LIGHT_SIZES = (0.25, 1.0, 4.0)
"""Factors on the light's width and height."""


def main_techniques() -> list[Technique]:
    """One of each kind: no shadow, one map, one map filtered in two ways, many maps, chosen maps, no maps."""
    return [
        make_technique("none"),
        make_technique("hard"),
        make_technique("pcss"),
        make_technique("variable_penumbra", {"kernels": "from_light"}),
        make_technique("uniform", {"grid": 9}),
        make_technique("adaptive"),
        make_technique("penumbra_wedges"),
        make_technique("bitmask"),
    ]


def without_maps() -> list[Technique]:
    """Those that large scenes, many lights and large lights are shown with."""
    return [make_technique("adaptive", {"visibility": "ray"}), make_technique("bitmask")]


@dataclass(frozen=True)
class Step:
    """One picture: how much of what there is, and what it is rendered with."""

    axis: str
    amount: float | None
    name: str
    open: Callable[[], Scene]
    size: tuple[int, int]
    techniques: Sequence[Technique]


def run(settings: Settings, notice: Notice) -> list[Measurement]:
    """What pixels, light samples, triangles and lights cost, in time and memory, for one technique of each kind."""
    chosen = steps(settings.size or SIZE)
    return measure_each(
        chosen, lambda step: step.name, lambda step, within: measure_step(step, settings, within), notice
    )


def steps(size: tuple[int, int]) -> Iterator[Step]:
    """All pictures, axis by axis."""
    width, height = size
    for share in SHARES:
        scaled = max(round(share * width), 1), max(round(share * height), 1)
        name = f"pixels {scaled[0]}x{scaled[1]}"
        yield Step("pixels", scaled[0] * scaled[1], name, builtin.figures, scaled, main_techniques())
    sampled = [make_technique("uniform", {"grid": grid}) for grid in GRIDS]
    sampled += [make_technique("adaptive", {"max_depth": depth}) for depth in DEPTHS]
    yield Step("light samples", None, "light samples", builtin.figures, size, sampled)
    for count in SPHERES:
        opened = partial(builtin.sphere_cube, count)
        triangles = opened().triangle_count
        yield Step("triangles", triangles, f"triangles {triangles}", opened, size, main_techniques())
    for count in LIGHTS:
        yield Step("lights", count, f"lights {count}", partial(lit_by, count), size, main_techniques())
    for count in MANY_LIGHTS:
        yield Step("lights", count, f"lights {count}", partial(lit_by, count), size, [make_technique("bitmask")])
    for count in HILLS:
        yield Step("hills", count, f"hills {count}", partial(hills, count), size, without_maps())
    for factor in LIGHT_SIZES:
        yield Step("light size", factor, f"light size {factor:g}", partial(lit_widely, factor), size, without_maps())


def hills(triangles: int) -> Scene:
    """A terrain under a low light."""
    scene = terrain(triangles)
    scene.lights, scene.camera = [SUN], OVER_HILLS
    return scene


def lit_widely(factor: float) -> Scene:
    """`figures` under its light, so many times as wide and high, with the same power."""
    scene = builtin.figures()
    (light,) = scene.lights
    assert isinstance(light, RectLight)
    dimmed = tuple(channel / factor**2 for channel in light.radiance)
    scene.lights = [replace(light, width=factor * light.width, height=factor * light.height, radiance=dimmed)]
    return scene


def lit_by(count: int) -> Scene:
    """`figures` under `count` rectangles side by side around its light, with the power of one."""
    scene = builtin.figures()
    (light,) = scene.lights
    assert isinstance(light, RectLight)
    dimmed = tuple(channel / count for channel in light.radiance)
    spacing = min(LIGHT_SPACING, LIGHT_ROW / max(count - 1, 1))
    places = [light.center + (place - (count - 1) / 2.0) * spacing * light.axes[0] for place in range(count)]
    scene.lights = [replace(light, position=tuple(at.tolist()), radiance=dimmed) for at in places]
    return scene


def measure_step(step: Step, settings: Settings, notice: Notice) -> Measurement:
    """All figures of a step. What the adapter cannot do is left out and named."""
    scene = step.open()
    assert scene.camera is not None, "built-in scenes have one"
    shot = Shot(step.name, scene, scene.camera, step.size)
    base = reference_frame(shot, settings.samples, notice)
    runs, failed = render_interleaved(
        shot,
        step.techniques,
        settings.repeats,
        lambda doing, share: notice(doing, 0.2 + 0.8 * share),
    )
    results = [base.result_of(run) for run in runs]
    for result in results:
        result.figures = _figures(step, result)
    return Measurement(shot, base.reference, results, failed, {"axis": step.axis})


def _figures(step: Step, result: Result) -> dict[str, Any]:
    if step.amount is None:
        return {"series": result.technique.name, "amount": result.stats["shadow_maps"]}
    return {"series": label_of(result.technique), "amount": step.amount}
