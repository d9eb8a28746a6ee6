"""What is shown on a terminal while measuring, and the table at the end."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from softshadows.compare.measure import Measurement, Notice

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

MOST_COLUMNS = 5
"""Techniques side by side in 80 columns."""

LEAST_SHARE = 0.01
"""Share of a run before which its end is not foretold."""


@contextmanager
def progress(console: Console) -> Iterator[Notice]:
    """A bar that says what is being done, how long it has taken and how long it still will; gone when it is done.

    Silent where the output is not a terminal.
    """
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    remaining = TextColumn("{task.fields[left]}")
    columns = (
        SpinnerColumn(),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
        remaining,
        TextColumn("{task.description}"),
    )
    started = time.monotonic()
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0, left="")

        def notice(doing: str, share: float) -> None:
            left = time_left(time.monotonic() - started, share)
            bar.update(task, description=doing, completed=share, left=left)

        yield notice


def time_left(elapsed_s: float, share: float) -> str:
    """What a run that has done `share` of its work still needs, in words; empty as long as nobody can tell."""
    if share < LEAST_SHARE:
        return ""
    left_s = elapsed_s * (1.0 - share) / share
    if left_s < 90.0:
        return f"{left_s:.0f} s left"
    return f"{left_s / 60.0:.0f} min left" if left_s < 5400.0 else f"{left_s / 3600.0:.1f} h left"


def results_table(measurements: Sequence[Measurement]) -> Table:
    """A row per scene and technique, errors as the mean over its lights."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1), pad_edge=False)
    table.add_column("scene", overflow="fold")
    table.add_column("technique", overflow="fold")
    for heading in ("shadow\nmaps", "ms", "rmse", "bias", "leak\nrate", "false\nshadow"):
        table.add_column(heading, justify="right", no_wrap=True)
    for measurement in measurements:
        for result in measurement.results:
            count = max(len(result.comparisons), 1)
            rmse, bias, leak, false_shadow = (
                sum(getattr(comparison, name) for comparison in result.comparisons) / count
                for name in ("rmse", "bias", "leak_rate", "false_shadow_rate")
            )
            table.add_row(
                measurement.shot.name,
                result.label,
                str(result.stats["shadow_maps"]),
                f"{result.frame_ms:.1f}",
                f"{rmse:.4f}",
                f"{bias:+.4f}",
                f"{leak:.2%}",
                f"{false_shadow:.2%}",
            )
    return table


def figures_table(measurement: Measurement) -> Table | None:
    """What the suite measured beyond the errors: a row per figure, a column per technique; None where it is nothing.

    With more techniques than fit side by side the table is turned around: a row per technique.
    """
    from rich import box
    from rich.table import Table

    given = [item for result in measurement.results for item in result.figures.items()]
    nested = {name for name, value in given if isinstance(value, dict)}
    names = [name for name in dict.fromkeys(name for name, _ in given) if name not in nested]
    if not names:
        return None
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1), pad_edge=False)
    table.add_column(measurement.shot.name, no_wrap=True)
    cells = {name: [_cell(result.figures.get(name)) for result in measurement.results] for name in names}
    labels = [result.label for result in measurement.results]
    if len(labels) > MOST_COLUMNS:
        for name in names:
            table.add_column(name.replace("_", "\n"), justify="right", overflow="fold")
        for label, *row in zip(labels, *cells.values(), strict=True):
            table.add_row(label.replace(":", "\n  "), *row)
    else:
        for label in labels:
            table.add_column(label.replace(":", "\n"), justify="right", overflow="fold")
        for name, row in cells.items():
            table.add_row(name, *row)
    return table


def _cell(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.3g}"
