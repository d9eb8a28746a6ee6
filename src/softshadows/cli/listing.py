"""`softshadows techniques`, `scenes` and `info`: what there is."""

from __future__ import annotations

import re
import sys

from softshadows.cli.parts import new_console


def techniques() -> None:
    """List the techniques, their options and the legal values."""
    from rich.table import Table

    from softshadows.techniques import TECHNIQUES
    from softshadows.techniques.options import as_text

    console = new_console()
    for name, cls in TECHNIQUES.items():
        console.print(f"[bold]{name}[/bold]  {_summary(cls)}", highlight=False)
        if cls.options():
            table = Table(box=None, show_header=False, padding=(0, 1, 0, 4))
            for option in cls.options():
                belongs = f"of {option.of}: " if option.of else ""
                meaning = f"{belongs}{option.help} [dim]({option.legal.words})[/dim]"
                table.add_row(f"{option.name}={as_text(option.default)}", meaning)
            for preset, chosen in cls.presets.items():
                said = ", ".join(f"{name}={as_text(value)}" for name, value in chosen.items())
                table.add_row(f"preset={preset}", said or "the defaults")
            console.print(table)


def scenes() -> None:
    """List the built-in scenes."""
    from rich.table import Table

    from softshadows.scene.builtin import SCENES, describe

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name in SCENES:
        table.add_row(f"[bold]{name}[/bold]", describe(name))
    new_console().print(table)


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


def _summary(cls: type) -> str:
    """The first sentence of a class's docstring, or of its module's."""
    text = " ".join((cls.__doc__ or sys.modules[cls.__module__].__doc__ or "").split())
    return re.split(r"(?<=[.!?])\s", text)[0]
