"""What the commands of the command line share: the size option, a terminal, notes, and a check before long work."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from softshadows.errors import OptionError

if TYPE_CHECKING:
    from rich.console import Console

SizeOption = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Picture size in pixels, such as `1024x768`.", show_default=False),
]


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
