"""The command line. Heavy imports wait inside the commands, so that `--help` answers at once.

Bad input, whatever it is, ends in one sentence on stderr and exit code 2.
"""

from __future__ import annotations

import re
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from softshadows.cli.bench import bench
from softshadows.cli.parts import SizeOption, check_folder, new_console, say
from softshadows.errors import OptionError, SoftShadowsError

if TYPE_CHECKING:
    from softshadows.scene.shot import Shot

BAD_INPUT = 2
PICTURES = (".png", ".exr", ".npz")


class OnMissing(StrEnum):
    """What to do about a texture that a model names and that is not there."""

    error = "error"
    warn = "warn"


class Profile(StrEnum):
    """What the device may use."""

    full = "full"
    portable = "portable"


class OneSentence(TyperGroup):
    """Turns our exceptions into a sentence on stderr and exit code 2."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except SoftShadowsError as error:
            typer.echo(f"softshadows: {' '.join(str(error).split())}", err=True)
            raise typer.Exit(BAD_INPUT) from None


app = typer.Typer(
    cls=OneSentence,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""Soft shadows from area and line lights, measured against ray-traced truth.

SCENE is a model file (glTF, GLB, OBJ, PLY, STL), the name of a built-in scene, or a shot: a TOML file that says
everything about a picture.

    softshadows render figures -o figures.png

    softshadows compare chair.glb --ground -t hard,pcss,uniform -o report/

    softshadows techniques
""",
)

app.add_typer(bench, name="bench")

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Model file, built-in scene or shot (.toml).", show_default=False)
]
OptionsOption = Annotated[
    list[str] | None,
    typer.Option(
        "-O",
        metavar="NAME=VALUE",
        help="An option of the technique; `softshadows techniques` lists them. Repeatable.",
        show_default=False,
    ),
]
LightOption = Annotated[
    list[str] | None,
    typer.Option(
        "--light",
        metavar="LIGHT",
        help="Replaces the scene's lights: a kind (rect, disk, line, point, spot, directional) and its properties, "
        "as `softshadows render -h` shows. Repeatable.",
        show_default=False,
    ),
]
CameraOption = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="CAMERA",
        help="Replaces the scene's camera, as `softshadows render -h` shows; metres and degrees.",
        show_default=False,
    ),
]
GroundOption = Annotated[bool, typer.Option("--ground", help="Add a plane under the scene's lowest point.")]
ProfileOption = Annotated[
    Profile,
    typer.Option("--profile", help="`portable` uses only what every WebGPU device has, browsers and phones included."),
]
OnMissingOption = Annotated[OnMissing, typer.Option("--on-missing", help="What to do about a missing texture.")]


@app.command()
def render(
    scene: SceneArgument,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Picture: .png (displayed), .exr or .npz (linear, every image by name)."),
    ],
    technique: Annotated[
        str | None,
        typer.Option("-t", "--technique", metavar="NAME", help="How to compute the shadows.", show_default=False),
    ] = None,
    options: OptionsOption = None,
    light: LightOption = None,
    camera: CameraOption = None,
    size: SizeOption = None,
    ground: GroundOption = False,
    on_missing: OnMissingOption = OnMissing.error,
    profile: ProfileOption = Profile.full,
) -> None:
    """Render a picture.

    `softshadows render figures -o figures.png`

    `softshadows render chair.glb --ground -t uniform -O grid=9 --size 800x600 -o chair.exr`

    `softshadows render chair.glb --camera position=3,2,4:target=0,1,0:fov=45 -o chair.png`

    `softshadows render chair.glb --light line:start=-1,2,0:end=1,2,0:radiance=30,30,30 -o chair.png`

    `--light rect:position=0,4,0:target=0,0,0:width=1:height=1:radiance=10,10,10`
    """
    console = new_console()
    if output.suffix.lower() not in PICTURES:
        raise OptionError(f"--output must end in one of {', '.join(PICTURES)}, got {str(output)!r}")
    check_folder(output.parent)
    with console.status("reading the scene"):
        shot = _open(scene, light, camera, size, ground, on_missing)
    with console.status("preparing the device"):
        from softshadows.compare.choice import technique_from
        from softshadows.renderer import Renderer

        chosen = technique_from(shot, technique, options or [])
        if chosen is None:
            renderer = Renderer(shot.scene, size=shot.size, profile=profile.value)
        else:
            renderer = Renderer(shot.scene, technique=chosen, size=shot.size, profile=profile.value)
    with console.status(f"rendering with {renderer.technique.name}"), renderer:
        frame = renderer.render(shot.camera)
        _save(frame, output)
    say(console, [*shot.notes, *(w for w in frame.stats.warnings if w not in shot.notes)])
    milliseconds = sum(frame.stats.gpu_ms.values())
    timing = f", {milliseconds:.1f} ms on the GPU" if milliseconds else ""
    console.print(
        f"{output}: {shot.size[0]}×{shot.size[1]}, technique {renderer.technique.name}, "
        f"{frame.stats.shadow_maps} shadow {'map' if frame.stats.shadow_maps == 1 else 'maps'}{timing}",
        highlight=False,
        soft_wrap=True,
    )


@app.command()
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
            "`pcss,uniform:grid=5,uniform:grid=9`. Left out: all that can do the scene's lights.",
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
        from softshadows.compare.choice import techniques_from
        from softshadows.compare.comparison import KEPT_FOLDER, Effort, Picture, write_report
        from softshadows.compare.comparison import compare as measure_all
        from softshadows.compare.console import progress, results_table
        from softshadows.compare.kept import Kept

        required = technique is not None and len(shots) == 1
        pictures = [Picture(shot, techniques_from(shot, technique, options or []), required) for shot in shots]
        kept = Kept(output / KEPT_FOLDER, fresh=fresh)
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


@app.command()
def techniques() -> None:
    """List the techniques, their options and the legal values."""
    from rich.table import Table

    from softshadows.techniques import TECHNIQUES
    from softshadows.techniques.base import legal_values

    console = new_console()
    for name, cls in TECHNIQUES.items():
        console.print(f"[bold]{name}[/bold]  {_summary(cls)}", highlight=False)
        if cls.options():
            table = Table(box=None, show_header=False, padding=(0, 1, 0, 4))
            for option in cls.options():
                meaning = f"{option.metadata['help']} [dim]({legal_values(option)})[/dim]"
                table.add_row(f"{option.name}={option.default}", meaning)
            console.print(table)


@app.command()
def scenes() -> None:
    """List the built-in scenes."""
    from rich.table import Table

    from softshadows.scene.builtin import SCENES, describe

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name in SCENES:
        table.add_row(f"[bold]{name}[/bold]", describe(name))
    new_console().print(table)


@app.command()
def info() -> None:
    """Show the graphics adapter, its limits, what it lacks, and the versions in use."""
    from rich.table import Table

    from softshadows.compare.environment import environment

    found = environment()
    adapter = found["adapter"]
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name in ("adapter", "type", "backend", "driver"):
        table.add_row(name, str(adapter[name]))
    table.add_row("features", ", ".join(adapter["features"]) or "none of the optional ones")
    for missing in adapter["fallbacks"]:
        table.add_row("without", missing)
    for name, limit in adapter["limits"].items():
        table.add_row(name, f"{limit / 2**20:,.0f} MiB" if name.endswith("size") else f"{limit:,}")
    table.add_row("processor", f"{found['cpu']}, {found['cpu_count']} cores")
    table.add_row("system", found["system"])
    table.add_row("versions", ", ".join(f"{name} {number}" for name, number in found["versions"].items() if number))
    if found["commit"]:
        table.add_row("commit", found["commit"])
    new_console().print(table)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"softshadows {version('softshadows')}")
        raise typer.Exit


@app.callback()
def _top(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and stop.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Options that come before any command; its help is the application's."""


def _open(
    scene: str, light: list[str] | None, camera: str | None, size: str | None, ground: bool, on_missing: OnMissing
) -> Shot:
    """The shot that SCENE and the options beside it describe."""
    from softshadows.scene.description import camera_from_text, light_from_text, size_from_text
    from softshadows.scene.shot import open_shot

    return open_shot(
        scene,
        camera=camera_from_text(camera) if camera is not None else None,
        lights=[light_from_text(text) for text in light or []],
        size=size_from_text(size) if size is not None else None,
        ground=ground,
        on_missing=on_missing.value,
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
        shot = _open(scene, light, cameras[0] if cameras else None, size, ground, on_missing)
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


def _save(frame: Any, output: Path) -> None:
    try:
        frame.save(output)
    except OSError as error:
        raise OptionError(f"{output} cannot be written: {error.strerror or error}") from error


def _summary(cls: type) -> str:
    """The first sentence of a class's docstring, or of its module's."""
    text = " ".join((cls.__doc__ or sys.modules[cls.__module__].__doc__ or "").split())
    return re.split(r"(?<=[.!?])\s", text)[0]


def main() -> None:
    """The `softshadows` command."""
    app(prog_name="softshadows")
