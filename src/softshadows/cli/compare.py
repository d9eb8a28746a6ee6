"""`softshadows compare`: techniques beside each other and the truth, as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from softshadows.cli.parts import (
    GroundOption,
    LightOption,
    OnMissing,
    OnMissingOption,
    OptionsOption,
    Profile,
    ProfileOption,
    SizeOption,
    check_folder,
    new_console,
    open_view,
    say,
)

if TYPE_CHECKING:
    from softshadows.scene.shot import Shot


def compare(
    scenes: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE...",
            help="Model files, built-in scenes or shots (.toml): a picture each.",
            show_default=False,
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for index.html, results.json and the images.")],
    technique: Annotated[
        str | None,
        typer.Option(
            "-t",
            "--techniques",
            metavar="NAMES",
            help="Names with commas between, each with options of its own where needed, one as often as you like: "
            "`pcss,uniform:grid=5,adaptive:preset=paper`. Left out: all that can do the scene's lights.",
            show_default=False,
        ),
    ] = None,
    options: OptionsOption = None,
    light: LightOption = None,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            "--camera",
            metavar="CAMERA",
            help="Replaces the scene's camera, as `softshadows render -h` shows. Repeatable: a picture each.",
            show_default=False,
        ),
    ] = None,
    size: SizeOption = None,
    ground: GroundOption = False,
    samples: Annotated[
        int, typer.Option("--samples", min=1, max=65536, help="Rays per pixel and light for the truth.")
    ] = 1024,
    repeats: Annotated[int, typer.Option("--repeats", min=1, max=1000, help="Timed frames of each technique.")] = 3,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Measure again what an earlier run into this folder has measured.")
    ] = False,
    on_missing: OnMissingOption = OnMissing.error,
    profile: ProfileOption = Profile.full,
) -> None:
    """Compare techniques with each other and with ray-traced truth: an HTML page, results.json, images.

    `softshadows compare blocker -t hard,pcss,uniform -o report/`

    `softshadows compare shot.toml near.toml -t uniform:grid=5,uniform:grid=17 --size 640x480 -o report/`

    -O applies to every technique that has the option. Several scenes and cameras are several pictures on one page;
    several lights are measured one by one, and their picture as a whole. An interrupted run goes on where it was when
    it is started again.
    """
    console = new_console()
    check_folder(output, may_be_new=True)
    with console.status("reading the scene"):
        shots = _views(scenes, light, camera, size, ground, on_missing)
    with console.status("preparing the device"):
        from softshadows.compare.cache import MeasurementCache
        from softshadows.compare.choice import techniques_from
        from softshadows.compare.comparison import CACHE_FOLDER, Effort, Picture, write_report
        from softshadows.compare.comparison import compare as measure_all
        from softshadows.compare.console import progress, results_table

        required = technique is not None and len(shots) == 1
        pictures = [Picture(shot, techniques_from(shot, technique, options or []), required) for shot in shots]
        kept = MeasurementCache(output / CACHE_FOLDER, fresh=fresh)
    try:
        with progress(console) as notice:
            measurements = measure_all(pictures, Effort(samples, repeats, profile.value), notice, kept)
            index = write_report(measurements, output)
            kept.forget_others()
    except KeyboardInterrupt:
        say(console, ["interrupted; the same command again goes on after what is measured"])
        raise
    for measurement in measurements:
        name = f"{measurement.shot.name}: " if len(measurements) > 1 else ""
        say(console, [name + sentence for sentence in [*measurement.shot.notes, *measurement.skipped]])
    console.print(results_table(measurements))
    console.print(
        f"open {index} in a browser; the figures are in {output / 'results.json'}", highlight=False, soft_wrap=True
    )


def _views(
    scenes: list[str],
    light: list[str] | None,
    cameras: list[str] | None,
    size: str | None,
    ground: bool,
    on_missing: OnMissing,
) -> list[Shot]:
    """A shot for every scene and camera, each with a name of its own."""
    from dataclasses import replace

    from softshadows.scene.description import camera_from_text

    views = [camera_from_text(text) for text in cameras or []]
    shots: list[Shot] = []
    for scene in scenes:
        shot = open_view(scene, light, cameras[0] if cameras else None, size, ground, on_missing)
        if len(views) < 2:
            shots.append(shot)
        shots += [
            replace(shot, camera=view, name=f"{shot.name}, view {number}") for number, view in enumerate(views, 1)
        ]
    taken: dict[str, int] = {}
    for index, shot in enumerate(shots):
        taken[shot.name] = taken.get(shot.name, 0) + 1
        if taken[shot.name] > 1:
            shots[index] = replace(shot, name=f"{shot.name} ({taken[shot.name]})")
    return shots
