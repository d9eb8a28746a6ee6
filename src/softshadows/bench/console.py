"""What `bench` shows on a terminal beside what `compare` does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from softshadows.bench.changes import Change

if TYPE_CHECKING:
    from rich.table import Table


def changes_table(title: str, changes: Sequence[Change]) -> Table:
    """A row per figure that moved."""
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1), pad_edge=False)
    for heading in ("picture", "technique", "figure"):
        table.add_column(heading, overflow="fold")
    for heading in ("before", "after", "change"):
        table.add_column(heading, justify="right", no_wrap=True)
    for change in changes:
        share = "" if change.share is None else f"{change.share:+.1%}"
        values = f"{change.before:.4g}", f"{change.after:.4g}", share
        table.add_row(change.picture, change.technique, change.figure, *values)
    return table
