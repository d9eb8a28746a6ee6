"""What the commands share: arguments and options, the shot that they describe, a terminal, notes, and early checks."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from softshadows.errors import OptionError

if TYPE_CHECKING:
    from rich.console import Console

    from softshadows.scene.shot import Shot


class OnMissing(StrEnum):
    """What to do about a texture that a model names and that is not there."""

    error = "error"
    warn = "warn"


class Profile(StrEnum):
    """What the device may use."""

    full = "full"
    portable = "portable"


SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Model file, built-in scene or shot (.toml).", show_default=False)
]
OptionsOption = Annotated[
    list[str] | None,
    typer.Option(
        "-O",
        metavar="NAME=VALUE",
        help="An option of the technique, such as `visibility=ray` or `visibility.denoise=true`, or `preset=paper`; "
        "`softshadows techniques` lists them. Repeatable.",
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
SizeOption = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Picture size in pixels, such as `1024x768`.", show_default=False),
]


def open_view(
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


def check_folder(folder: Path, *, may_be_new: bool = False) -> None:
    """OptionError where a result could not be written: better before an hour's work than after it."""
    if may_be_new:
        folder = next(place for place in (folder, *folder.absolute().parents) if place.exists())
        if not folder.is_dir():
            raise OptionError(f"the output needs a folder, but {str(folder)!r} is a file")
    if not folder.is_dir():
        raise OptionError(f"the folder {str(folder)!r} for the output does not exist; make it first")


def say(console: Console, sentences: Iterable[str]) -> None:
    for sentence in dict.fromkeys(sentences):
        console.print(f"note: {sentence}", style="dim", highlight=False, markup=False, soft_wrap=True)


def new_console() -> Console:
    from rich.console import Console

    return Console()
