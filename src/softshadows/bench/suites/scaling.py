"""Time and memory of the main techniques over pixels, light samples, triangles and lights.

One thing grows at a time, from what the others have in common: `figures`, 256×192 pixels, one light.

pixels          `figures` with 128×96 to 512×384 pixels
light samples   `figures` with 4 to 289 maps (`uniform`), and with ever deeper refinement (`adaptive`)
triangles       `sphere_cube` with 1 to 64 spheres: 764 to 48 770 triangles
lights          `figures` with 1 to 4 rectangles that share the power of one

Lights move by a micrometre before every timed frame, so that nothing is kept from the last one, and techniques take
turns. A picture's figures: `axis`, the name of what grows. A technique's: `amount`, how much of it there is (for light
samples the number of maps), and `series`, which figures belong to one curve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

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
LIGHTS = (1, 2, 4)
LIGHT_SPACING = 0.5
"""Metres between the centres of several lights."""


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
    ]


@dataclass(frozen=True)
class Step:
    """One picture: how much of what there is, and what it is rendered with."""

    axis: str
    amount: int | None
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


def lit_by(count: int) -> Scene:
    """`figures` under `count` rectangles side by side around its light, with the power of one."""
    scene = builtin.figures()
    (light,) = scene.lights
    assert isinstance(light, RectLight)
    dimmed = tuple(channel / count for channel in light.radiance)
    places = [light.center + (place - (count - 1) / 2.0) * LIGHT_SPACING * light.axes[0] for place in range(count)]
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
