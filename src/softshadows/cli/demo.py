"""`make demo`: a built-in scene through a few techniques, with the truth and the error beside them, in ./demo/."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from softshadows.compare.comparison import write_report
from softshadows.compare.console import progress, results_table
from softshadows.compare.measure import measure
from softshadows.compare.plates import plates
from softshadows.compare.results import write_bytes
from softshadows.errors import SoftShadowsError
from softshadows.scene.shot import open_shot
from softshadows.techniques import DEFAULT, make_technique

FOLDER = Path("demo")
SCENE, SIZE, SAMPLES = "figures", (512, 384), 256
SHOWN = DEFAULT
BESIDE = ("hard", "pcf", "pcss", "vsm", "variable_penumbra", "penumbra_wedges", "adaptive", "uniform")


def main() -> None:
    """Render, measure, write ./demo/ and say where to look."""
    from rich.console import Console

    console = Console()
    shot = replace(open_shot(SCENE), size=SIZE)
    techniques = [make_technique(name) for name in (*BESIDE, SHOWN)]
    with progress(console) as notice:
        measurement = measure(shot, techniques, samples=SAMPLES, repeats=1, notice=notice)
        index = write_report([measurement], FOLDER)
        files = {"picture": "picture.png", "visibility": "visibility.png", "truth": "truth.png", "error": "error.png"}
        for caption, image in plates(measurement)[SHOWN]:
            if caption in files:
                write_bytes(image, FOLDER / files[caption])
    console.print(results_table([measurement]))
    size = f"{SIZE[0]}×{SIZE[1]}"
    console.print(
        f"The {SCENE} scene under a rectangle light, {size}; its shadow by {SHOWN!r}, the truth and the error:"
    )
    for file in files.values():
        console.print(f"  {FOLDER / file}")
    console.print(f"All of them side by side: open [bold]{index}[/bold] in a browser.")


if __name__ == "__main__":
    try:
        main()
    except SoftShadowsError as error:
        sys.exit(f"softshadows: {error}")
