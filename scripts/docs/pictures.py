"""The pictures of README and documentation, made anew.

    python scripts/docs/pictures.py                  # all of them: minutes on a software driver
    python scripts/docs/pictures.py pcss refine demo # of a technique, an example, or README's

A technique has two, declared in `SHOWN`: one that serves it, and one of the failure that its manual names, on the scene
that the manual names. Their captions, with what was measured, go to docs/images/techniques/captions.json.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from gallery_page import EXAMPLES, examples
from PIL import Image, ImageDraw

import softshadows as ss
from softshadows.bench.suites.linear import under_a_line
from softshadows.image.display import display, to_8_bit
from softshadows.techniques import DEFAULT, TECHNIQUES

IMAGES = Path(__file__).parents[2] / "docs" / "images"
CAPTIONS = IMAGES / "techniques" / "captions.json"
SIZE = (400, 300)
EXAMPLE_SIZE = (560, 420)
MOST_WIDTH = 1120
MOST_BYTES = 100_000
DEMO_BYTES = 250_000
GAP = 4
"""Grey pixels between the panels of a picture."""
NEARLY_WHITE = 244
SAMPLES = 256
AMPLIFICATION = 5.0

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Shown:
    """A picture of a technique: what it shows in words, the scene, its own options and view where they matter."""

    words: str
    scene: str
    options: dict[str, Any] = field(default_factory=dict)
    line: bool = False
    camera: ss.Camera | None = None


NEAR_THE_CARD = ss.Camera((3.6, 5.4, 6.4), (0.3, 0.3, 0.1), 38.0)
"""The shadow of `blocker`, as large as fits."""
ABOVE_THE_EDGE = ss.Camera((3.2, 1.6, 2.9), (1.6, 0.0, 1.0), 30.0)
"""Near enough to the shadow of `blocker` that its penumbra fills the picture."""
SPHERES = ss.Camera((2.4, 2.85, 3.3), (-0.1, 0.3, 0.0), 26.0)
"""The cube of `sphere_cube` and its shadow, as large as they fit."""
BARS = ss.Camera((0.75, 0.9, 1.5), (0.35, 0.1, 0.25), 38.0)
"""The shadows of a few bars of `fence`."""

SHOWN: dict[str, tuple[Shown, Shown]] = {
    "none": (
        Shown("the unshadowed picture", "room"),
        Shown("whatever casts a shadow is missing", "figures"),
    ),
    "hard": (
        Shown("the light's centre alone", "figures"),
        Shown("there is no penumbra", "figures"),
    ),
    "pcf": (
        Shown("softened by a few texels", "figures"),
        Shown("the kernel's width, where the penumbra is metres wide", "blocker", camera=NEAR_THE_CARD),
    ),
    "pcss": (
        Shown("penumbrae that grow with the distance", "figures"),
        Shown("occluders at different heights overlap, and their mean is none of them", "sphere_cube", camera=SPHERES),
    ),
    "vsm": (
        Shown("a smooth edge over a single receiver", "blocker", {"kernel": 15}, camera=NEAR_THE_CARD),
        Shown(
            "light bleeds into the umbra where occluders overlap",
            "sphere_cube",
            {"kernel": 25, "light_bleed_reduction": 0.0},
            camera=SPHERES,
        ),
    ),
    "uniform": (
        Shown("289 shadow maps", "room"),
        Shown(
            "seen from near, a penumbra shows the steps between samples", "blocker", {"grid": 9}, camera=ABOVE_THE_EDGE
        ),
    ),
    "adaptive": (
        Shown("maps only where the picture needs them", "room"),
        Shown("bars that hide no corner of the light go unseen", "fence", {"max_depth": 1}, camera=BARS),
    ),
    "bitmask": (
        Shown("256 samples of the light in one walk a pixel", "room"),
        Shown("an edge along the rows shows their steps", "blocker", {"rows": 4}, camera=ABOVE_THE_EDGE),
    ),
    "variable_penumbra": (
        Shown("kernels as wide as the light asks for", "mannequin", {"kernels": "from_light"}),
        Shown("the paper's bands do not know the light's size", "blocker", camera=NEAR_THE_CARD),
    ),
    "line_shadow_maps": (
        Shown("three to nine maps for a line light", "figures", line=True),
        Shown("two maps see little of a deep stack", "sphere_cube", {"samples": 2}, line=True, camera=SPHERES),
    ),
    "occluding_edges": (
        Shown("five maps for a line light", "figures", line=True),
        Shown("occluders as thin as a texel of the map", "fence", {"resolution": 200}, line=True, camera=BARS),
    ),
    "penumbra_wedges": (
        Shown("exact at any distance, without a map", "figures", {"blending": "union"}),
        Shown("sums are too dark where silhouettes overlap", "sphere_cube", {"blending": "additive"}, camera=SPHERES),
    ),
}
"""Each technique's picture, and the picture of its failure."""


def main(names: list[str]) -> None:
    """Make the pictures that `names` asks for, or all."""
    makers = {name: technique_pictures for name in TECHNIQUES}
    makers |= {script.stem: example_picture for script in examples()} | {"demo": demo_picture}
    unknown = set(names) - set(makers)
    if unknown:
        sys.exit(f"there is no picture of {sorted(unknown)[0]!r}; there are {', '.join(makers)}")
    for name in names or makers:
        print(name, flush=True)
        makers[name](name)


def technique_pictures(name: str) -> None:
    """A technique's picture beside its visibility; its failure's visibility, truth and error."""
    good, bad = SHOWN[name]
    shown = _measured(name, good)
    _save(IMAGES / "techniques" / f"{name}.png", [display(shown.frame.color), to_8_bit(shown.visibility)])
    failed = _measured(name, bad)
    panels = [to_8_bit(failed.visibility), to_8_bit(failed.truth), to_8_bit(failed.error_map)]
    _save(IMAGES / "techniques" / f"{name}-fails.png", panels)
    captions = json.loads(CAPTIONS.read_text(encoding="utf-8")) if CAPTIONS.exists() else {}
    captions[name] = {
        "picture": f"{shown.label}: {good.words}. Beside it the visibility alone; {shown.figures}.",
        "failure": f"{failed.label}: {bad.words}. Visibility, truth, and error: orange too light, blue too dark, full "
        f"colour at {1 / AMPLIFICATION:g}; {failed.figures}.",
    }
    ordered = {key: captions[key] for key in TECHNIQUES if key in captions}
    CAPTIONS.write_text(json.dumps(ordered, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def example_picture(name: str) -> None:
    """Run an example at the gallery's size, and keep the picture that it writes."""
    sys.path.insert(0, str(EXAMPLES))
    example = importlib.import_module(name)
    (IMAGES / "examples").mkdir(parents=True, exist_ok=True)
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            example.main(size=SMALL.get(name, EXAMPLE_SIZE))
            if Path(f"{name}.gif").exists():
                (IMAGES / "examples" / f"{name}.gif").write_bytes(Path(f"{name}.gif").read_bytes())
            else:
                _save(IMAGES / "examples" / f"{name}.png", [np.asarray(Image.open(f"{name}.png"))])
        finally:
            os.chdir(before)


SMALL = {
    "compare_techniques": (400, 300),
    "shadow_mattes": (280, 210),
    "moving_light": (200, 150),
    "refine": (400, 300),
}
"""Sizes of examples whose picture is a sheet of several, or moves."""


def demo_picture(name: str) -> None:
    """README's: the room by the default technique, and where three techniques err on it."""
    shot = ss.load_shot(EXAMPLES / "desk.toml")
    scene = ss.Scene(shot.scene.nodes, shot.scene.lights[:1], shot.camera)
    picture = display(ss.render(scene, size=(600, 450)).color)
    column = []
    for technique in ("hard", "pcss", DEFAULT):
        frame = ss.render(scene, technique=technique, size=(200, 150))
        result = _compared(technique, frame, scene)
        tile = Image.fromarray(to_8_bit(result.error_map))
        label = f"{technique}: error {result.rmse:.3f}"
        draw = ImageDraw.Draw(tile)
        draw.rectangle((0, 0, draw.textlength(label) + 7, 13), fill=(255, 255, 255))
        draw.text((4, 1), label, fill=(0, 0, 0))
        column.append(np.asarray(tile))
    _save(IMAGES / f"{name}.png", [picture, np.vstack(column)], DEMO_BYTES)


# -- Measuring ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Result:
    """A frame with its figures: images are (height, width) visibility and truth, (height, width, 3) error."""

    label: str
    frame: ss.Frame
    visibility: npt.NDArray[np.float32]
    truth: npt.NDArray[np.float32]
    error_map: npt.NDArray[np.float32]
    rmse: float
    leak_rate: float

    @property
    def figures(self) -> str:
        leaks = f", leak rate {self.leak_rate:.1%}" if self.leak_rate >= 5e-4 else ""
        return f"rmse {self.rmse:.3f}{leaks}"


def _measured(name: str, shown: Shown) -> Result:
    scene = ss.scenes.make(shown.scene)
    if shown.line:
        scene = under_a_line(shown.scene, scene).scene
    frame = ss.render(scene, shown.camera, technique=name, options=shown.options, size=SIZE)
    light = "a line light" if shown.line else "its rectangle light"
    options = "".join(f" {key}={value}" for key, value in shown.options.items())
    return _compared(f"`{name}{options}` on `{shown.scene}` under {light}", frame, scene)


def _compared(label: str, frame: ss.Frame, scene: ss.Scene) -> Result:
    truth, mask = ss.truth.visibility(scene, frame, samples=SAMPLES)[0], frame.surface & frame.facing[0]
    found = ss.metrics.compare(frame.visibility[0], truth, mask)
    error = ss.metrics.signed_error_image(frame.visibility[0], truth, mask, amplification=AMPLIFICATION)
    return Result(label, frame, frame.visibility[0], truth, error, found.rmse, found.leak_rate)


# -- Saving ------------------------------------------------------------------------------------------------------------


def _save(path: Path, panels: list[Pixels], most_bytes: int = MOST_BYTES) -> None:
    """Panels side by side; in 256 colours, dithered, where all of them would make a large file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    shown = [panel if panel.ndim == 3 else np.repeat(panel[..., None], 3, axis=2) for panel in panels]
    gap = np.full((len(shown[0]), GAP, 3), 128, np.uint8)
    sheet = Image.fromarray(np.hstack([part for panel in shown for part in (gap, panel)][1:]))
    if sheet.width > MOST_WIDTH:
        sheet = sheet.resize((MOST_WIDTH, round(sheet.height * MOST_WIDTH / sheet.width)), Image.Resampling.LANCZOS)
    sheet.save(path, optimize=True)
    if path.stat().st_size > most_bytes:
        palette = sheet.quantize(256, method=Image.Quantize.MAXCOVERAGE)
        few = sheet.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
        colors = np.reshape(few.getpalette() or [], (-1, 3))
        colors[colors.min(axis=1) >= NEARLY_WHITE] = 255  # no error, fully lit: white without a tint
        few.putpalette(colors.ravel().tolist())
        few.save(path, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1:])
