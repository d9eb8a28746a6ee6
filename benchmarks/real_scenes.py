"""Render every model and shot of a folder with several techniques: a table, and one sheet of all pictures to look at.

    SOFTSHADOWS_SCENES=path/to/scenes python benchmarks/real_scenes.py [--out report/real_scenes] [--size 480x360]

The folder holds model files (glTF 2.0, GLB, OBJ, PLY, STL) at most one folder down, and shots (TOML) beside them or in
folders of their own; `--only TEXT` keeps those whose path contains TEXT. A model without a camera or a light is given
both, as on the command line. With `--truth N` each picture's shadow is also compared with N rays per pixel, and the
sheet shows the signed error beside it.

A row with "no" under "sound" holds a number that is not finite or a visibility outside 0..1; such rows, and files that
do not load, make the exit status 1.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

import softshadows as ss
from softshadows.compare.choice import techniques_from
from softshadows.image.display import display, to_8_bit
from softshadows.scene.shot import Shot, open_shot

TECHNIQUES = "pcss,uniform:grid=5"
SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".toml")
COLUMNS = 4
CAPTION = 14  # pixels above each picture


@dataclass(frozen=True, eq=False)
class Row:
    """One technique on one scene. `error` is the mean absolute error where truth was asked for."""

    name: str
    technique: str
    triangles: int
    load_seconds: float
    seconds: float
    sound: bool
    lit: float
    error: float | None


@dataclass(frozen=True, eq=False)
class Tile:
    """A picture of the sheet: (height, width, 3) uint8 and the words above it."""

    caption: str
    image: npt.NDArray[np.uint8]


def sources(folder: Path, only: str) -> list[Path]:
    """The model files and shots of `folder`, sorted by path."""
    found = [path for pattern in ("*", "*/*") for path in folder.glob(pattern) if path.suffix.lower() in SUFFIXES]
    return sorted(path for path in found if only in str(path.relative_to(folder)))


def is_sound(frame: ss.Frame) -> bool:
    """All numbers finite, visibility in 0..1, and something to see."""
    visibility = frame.visibility
    finite = bool(np.isfinite(frame.color).all() and np.isfinite(visibility).all())
    return finite and bool((visibility >= 0.0).all() and (visibility <= 1.0).all() and frame.surface.any())


def render(shot: Shot, load_seconds: float, techniques: str, samples: int) -> Iterator[tuple[Row, list[Tile]]]:
    """A row and its tiles for each technique."""
    truth, triangles = None, shot.scene.triangle_count
    for technique, text in zip(techniques_from(shot, techniques, []), techniques.split(","), strict=True):
        start = time.perf_counter()
        frame = ss.render(shot.scene, shot.camera, technique=technique, size=shot.size)
        seconds = time.perf_counter() - start
        tiles = [Tile(f"{shot.name}  {text}", display(frame.color))]
        error, mask = None, frame.facing
        if samples:
            truth = ss.truth.visibility(shot.scene, frame, samples=samples) if truth is None else truth
            error = float(np.abs(frame.visibility - truth)[mask].mean()) if mask.any() else 0.0
            signed = ss.metrics.signed_error_image(frame.visibility[0], truth[0], mask[0])
            tiles.append(Tile(f"{shot.name}  {text}: error", to_8_bit(signed)))
        lit = float(frame.visibility[:, frame.surface].mean()) if frame.surface.any() else 1.0
        yield Row(shot.name, text, triangles, load_seconds, seconds, is_sound(frame), lit, error), tiles


def sheet(tiles: Sequence[Tile], size: tuple[int, int]) -> Image.Image:
    """All tiles in rows of `COLUMNS`."""
    width, height = size
    rows = -(-len(tiles) // COLUMNS)
    picture = Image.new("RGB", (COLUMNS * width, max(rows, 1) * (height + CAPTION)), "white")
    for index, tile in enumerate(tiles):
        x, y = index % COLUMNS * width, index // COLUMNS * (height + CAPTION)
        ImageDraw.Draw(picture).text((x + 2, y + 1), tile.caption, fill="black")
        picture.paste(Image.fromarray(tile.image), (x, y + CAPTION))
    return picture


def table(rows: Sequence[Row]) -> str:
    """The rows as text in columns."""
    lines = [
        f"{'scene':28}{'technique':20}{'triangles':>10}{'load s':>8}{'frame s':>9}{'lit':>6}{'sound':>7}{'error':>8}"
    ]
    for row in rows:
        error = "" if row.error is None else f"{row.error:.4f}"
        lines.append(
            f"{row.name[:27]:28}{row.technique[:19]:20}{row.triangles:>10}{row.load_seconds:>8.1f}{row.seconds:>9.1f}"
            f"{row.lit:>6.0%}{'yes' if row.sound else 'no':>7}{error:>8}"
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description="Render every model and shot of the folder SOFTSHADOWS_SCENES.")
    parser.add_argument(
        "--out", type=Path, default=Path("report/real_scenes"), help="folder for sheet.png and table.txt"
    )
    parser.add_argument("--size", default="480x360", help="WIDTHxHEIGHT of each picture")
    parser.add_argument("--techniques", default=TECHNIQUES, help="as of `softshadows compare`")
    parser.add_argument("--truth", type=int, default=0, metavar="N", help="compare with N rays per pixel")
    parser.add_argument("--only", default="", help="keep files whose path contains this text")
    arguments = parser.parse_args()
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if not folder:
        parser.error("set SOFTSHADOWS_SCENES to a folder of model files and shots")
    width, height = (int(number) for number in arguments.size.split("x"))

    rows: list[Row] = []
    tiles: list[Tile] = []
    failures: list[str] = []
    for path in sources(Path(folder), arguments.only):
        print(path.relative_to(folder), flush=True)
        try:
            start = time.perf_counter()
            shot = open_shot(path, size=(width, height), on_missing="warn")
            seconds = time.perf_counter() - start
            for row, pictures in render(shot, seconds, arguments.techniques, arguments.truth):
                rows.append(row)
                tiles.extend(pictures)
        except ss.SoftShadowsError as error:
            failures.append(f"{path.relative_to(folder)}: {error}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    sheet(tiles, (width, height)).save(arguments.out / "sheet.png")
    text = "\n".join([table(rows), *failures])
    (arguments.out / "table.txt").write_text(text + "\n", encoding="utf-8")
    print(text)
    print(f"{arguments.out / 'sheet.png'} shows all pictures.")
    return int(bool(failures) or not all(row.sound for row in rows))


if __name__ == "__main__":
    sys.exit(main())
