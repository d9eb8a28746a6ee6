"""The tables of measured figures in README and documentation, made from benchmarks/results; nothing is written by hand.

    python scripts/docs/tables.py            # writes README's tables anew, between their markers
    softshadows bench choice --repeats 3 --json benchmarks/results/choice.json     # measures what most of them show
    python benchmarks/accuracy.py ...                                              # the others: see `accuracy`

A table stands in README between `<!-- table: NAME -->` and `<!-- end -->`; written pages of the documentation name it
in the same way, without an end, and hooks.py fills it in. A test fails where README holds anything else.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from manual import source, summary
from prose import table

from softshadows.techniques import TECHNIQUES

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "benchmarks" / "results"
README = ROOT / "README.md"
BLOCK = re.compile(r"<!-- table: (\w+) -->\n.*?<!-- end -->", re.DOTALL)

BOUNDS = (0.1, 0.05, 0.02, 0.01, 0.005)
"""Errors that the table of choices asks for: rmse of visibility over all pixels that face the light."""

Picture = dict[str, Any]
Row = dict[str, Any]


def main() -> None:
    """Write README's tables."""
    README.write_text(filled(README.read_text(encoding="utf-8")), encoding="utf-8")


def filled(text: str) -> str:
    """`text` with the tables between its markers made anew."""
    return BLOCK.sub(lambda match: f"<!-- table: {match[1]} -->\n\n{TABLES[match[1]]()}\n\n<!-- end -->", text)


# -- What bench choice measured ----------------------------------------------------------------------------------------


@cache
def choice() -> dict[str, Any]:
    """The results of `softshadows bench choice`."""
    return json.loads((RESULTS / "choice.json").read_text(encoding="utf-8"))


def pictures(kind: str) -> list[Picture]:
    """The measured pictures under a light of this kind."""
    return [picture for picture in choice()["pictures"] if picture["lights"][0]["type"] == kind]


def techniques() -> str:
    """README's table: every technique's first sentence, source, lights, and its error and time on `figures`."""
    measured = {kind: {row["name"]: row for row in reversed(pictures(kind)[0]["techniques"])} for kind in LIGHTS}
    rows = []
    for name, cls in TECHNIQUES.items():
        row = [f"`{name}`", summary(cls), source(cls)]
        for kind in LIGHTS:
            found = measured[kind].get(name)
            row += [_error(found), _time(found)] if found else ["", ""]
        rows.append(row)
    head = ["name", "what it computes", "source"]
    for light in LIGHTS.values():
        head += [f"{light}: rmse", "ms"]
    return table(head, rows, right=4)


LIGHTS = {"rect": "rectangle", "line": "line"}


def technique_figures(name: str) -> str:
    """Everything that was measured of one technique, a row per picture and set of options."""
    rows = [
        [picture["scene"], _options(row), *_figures(row)]
        for picture in choice()["pictures"]
        for row in picture["techniques"]
        if row["name"] == name
    ]
    head = ["scene", "options", *COLUMNS]
    return table(head, rows, right=7) + f"\n\n{conditions()}"


def by_error() -> str:
    """The fastest technique whose error is below each bound, for every picture."""
    shown = choice()["pictures"]
    rows = []
    for bound in BOUNDS:
        row = [f"{bound:g}"]
        for picture in shown:
            able = [one for one in picture["techniques"] if _rmse(one) <= bound]
            best = min(able, key=lambda one: one["frame_ms"], default=None)
            row.append(f"{_label(best)}, {_time(best)} ms" if best else "none")
        rows.append(row)
    return table(["rmse at most", *(picture["scene"] for picture in shown)], rows)


def front() -> str:
    """Errors and times of all techniques, picture by picture; in bold those that no other one beats in both."""
    parts = []
    for picture in choice()["pictures"]:
        rows = []
        for row in sorted(picture["techniques"], key=lambda one: one["frame_ms"]):
            beaten = any(
                other["frame_ms"] < row["frame_ms"] and _rmse(other) <= _rmse(row) for other in picture["techniques"]
            )
            label = _label(row)
            rows.append([label if beaten else f"**{label}**", *_figures(row)])
        head = ["technique", *COLUMNS]
        parts.append(f"### {picture['scene']}\n\n" + table(head, rows, right=7))
    return "\n\n".join(parts)


def conditions() -> str:
    """What the figures of bench choice were measured on, in a sentence."""
    found, first = choice()["environment"], choice()["pictures"][0]
    width, height = first["size"]
    return (
        f"{width}×{height} pixels, truth of {first['truth']['samples']} rays per pixel; times are medians of whole "
        f"frames with their read-back, on {found['adapter']['adapter']} ({found['cpu']}, {found['cpu_count']} cores). "
        "`softshadows bench choice` measures them again."
    )


COLUMNS = ("rmse", "ms", "bias", "leak rate", "false-shadow rate", "maps", "look-ups")


def _figures(row: Row) -> list[str]:
    light = row["lights"][0]
    return [
        _error(row),
        _time(row),
        _signed(light["bias"]),
        _rate(light["leak_rate"]),
        _rate(light["false_shadow_rate"]),
        str(row["shadow_maps"]),
        f"{row['lookups_per_pixel']:.3g}",
    ]


def _label(row: Row) -> str:
    """The technique, and the options that are not its defaults."""
    options = _options(row)
    return f"`{row['name']}` {options}" if options else f"`{row['name']}`"


def _options(row: Row) -> str:
    return " ".join(row["label"].split(":")[1:])


def _rmse(row: Row) -> float:
    return row["lights"][0]["rmse"]


def _error(row: Row) -> str:
    return f"{_rmse(row):.4f}" if _rmse(row) < 0.01 else f"{_rmse(row):.3f}"


def _signed(error: float) -> str:
    return f"{error:+.4f}".replace("-0.0000", "0").replace("+0.0000", "0").replace("-", "−")


def _rate(share: float) -> str:
    """A share of pixels, in percent."""
    return "0" if share == 0.0 else f"{share:.2%}" if share >= 1e-4 else "< 0.01%"


def _time(row: Row) -> str:
    return f"{row['frame_ms']:,.0f}".replace(",", " ")


# -- What benchmarks/accuracy.py measured ------------------------------------------------------------------------------

ACCURACY = ("uniform-builtin-512.json", "uniform-shots-1024.json")


def accuracy() -> str:
    """How near `uniform` with 17×17 samples comes to the truth, and how much of its error is the light's sampling."""
    rows = []
    for row in _accuracy_rows():
        width, height = row["size"]
        leak, false_shadow = _rate(row["leak_rate"]), _rate(row["false_shadow_rate"])
        cells = [f"{row[key]:.4f}" for key in ("rmse", "lattice_rmse")]
        rows.append([row["scene"], f"{width}×{height}", *cells, _signed(row["bias"]), leak, false_shadow])
    head = ["scene", "size", "rmse", "of it light sampling", "bias", "leak rate", "false-shadow rate"]
    return table(head, rows, right=5)


def _accuracy_rows() -> Iterator[Row]:
    for file in ACCURACY:
        rows = json.loads((RESULTS / file).read_text(encoding="utf-8"))["rows"]
        yield from (row for row in rows if row["weights"] == "trapezoid")


TABLES = {
    "techniques": techniques,
    "by_error": by_error,
    "front": front,
    "conditions": conditions,
    "accuracy": accuracy,
}
"""The tables that pages may ask for."""


if __name__ == "__main__":
    main()
