"""The command line. Heavy imports wait inside the commands, so that `--help` answers at once.

Bad input, whatever it is, ends in one sentence on stderr and exit code 2.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from softshadows.cli.bench import bench
from softshadows.cli.compare import compare
from softshadows.cli.listing import info, scenes, techniques
from softshadows.cli.render import render
from softshadows.errors import SoftShadowsError

BAD_INPUT = 2


class OneSentence(TyperGroup):
    """Selection our exceptions into a sentence on stderr and exit code 2."""

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

for command in (render, compare, techniques, scenes, info):
    app.command()(command)
app.add_typer(bench, name="bench")


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


def main() -> None:
    """The `softshadows` command."""
    app(prog_name="softshadows")
