"""The benchmark page: committed results.json files as Markdown with charts, `softshadows bench report`.

Nothing but the files goes in, so that the same files give the same text; a test holds the committed page against that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from softshadows.bench.charts import COLOURS, Mark, Series, chart
from softshadows.bench.suites import SUITES, describe
from softshadows.compare.comparison import file_stem
from softshadows.errors import OptionError

IMAGES = Path("images", "benchmarks")
"""Where the charts are, seen from the page."""
PEERS = "peers"
MEBIBYTE = 2**20
MOST_SERIES = len(COLOURS)
"""More cannot be told apart."""
LEAST_RMSE = 1e-4
"""Drawn there if it is less: the scale is logarithmic."""

Row = dict[str, Any]
Picture = dict[str, Any]

INTRODUCTION = """# Benchmarks

Made by `softshadows bench report` from the files in `benchmarks/results`; the figures are theirs.

- **ms**: the median wall time of a frame with its read-back, among frames interleaved with the other techniques of the
  table; behind it the fastest and the slowest. Before each the lights move by a micrometre, so that all is redrawn.
- **rmse**: the distance of visibility (1 lit, 0 umbra) from ray-traced truth, over pixels that face the light.
- **leaks**: the share of true umbra with visibility above 0.1; **false shadow**: the share of truly lit pixels with
  less than 0.9. With several lights, all of these are means over them.
- **look-ups**: those of a pixel; **MiB**: what a frame holds on the GPU.

Two files of one suite are compared by `softshadows bench compare BEFORE AFTER`."""

PEERS_SAY = "Other renderers on the same scene, at the same size, against the same truth, in one run."


def benchmarks_page(files: Sequence[dict[str, Any]]) -> tuple[str, dict[str, str]]:
    """The page, and the charts that it shows by file name."""
    charts: dict[str, str] = {}
    sections = [INTRODUCTION, *(_section(data, charts) for data in files)]
    return "\n\n".join(sections) + "\n", charts


def committed_results(root: Path) -> list[Path]:
    """The files of suites and peers in a checkout's benchmarks/results; OptionError where there is none."""
    folder = root / "benchmarks" / "results"
    found = [path for suite in (*SUITES, PEERS) if (path := folder / f"{suite}.json").is_file()]
    if not found:
        raise OptionError(f"{folder} holds no results of a suite: name JSON files, or run in the project's folder")
    return found


def _section(data: dict[str, Any], charts: dict[str, str]) -> str:
    suite, pictures = data["suite"], data["pictures"]
    parts = [f"## {suite}", describe(suite) if suite in SUITES else PEERS_SAY, _command(data), _machine(data)]
    if any("axis" in picture["figures"] for picture in pictures):
        parts += _growth(suite, pictures, charts)
    else:
        name = f"{file_stem(suite)}-error-against-time.svg"
        charts[name] = chart(_error_against_time(pictures), "ms per frame", "rmse", joined=False)
        parts.append(_image(name, f"{suite}: error against time, a mark for each picture; lower left is better"))
        parts += _matrices(pictures) if _is_matrix(pictures) else _tables(pictures)
    skipped = [f"- {picture['scene']}: {sentence}" for picture in pictures for sentence in picture["skipped"]]
    if skipped:
        parts.append("Left out:\n\n" + "\n".join(skipped))
    return "\n\n".join(parts)


def _command(data: dict[str, Any]) -> str:
    """What measures the figures again, with as many rays and frames."""
    suite, pictures = data["suite"], data["pictures"]
    program = "python benchmarks/peers/run.py" if suite == PEERS else f"softshadows bench {suite}"
    rays = max(picture["truth"]["samples"] for picture in pictures)
    frames = max(row["times"]["frame"]["frames"] for picture in pictures for row in picture["techniques"])
    return f"`{program} --samples {rays} --repeats {frames} --json benchmarks/results/{suite}.json`"


def _machine(data: dict[str, Any]) -> str:
    """What the figures were measured on, and against."""
    environment = data["environment"]
    adapter = environment["adapter"]
    versions = ", ".join(f"{name} {number}" for name, number in environment["versions"].items() if number)
    rays = sorted({picture["truth"]["samples"] for picture in data["pictures"]})
    entries = [
        f"{adapter['adapter']}, {adapter['backend']}, {adapter['driver']}",
        f"{environment['cpu']}, {environment['cpu_count']} cores; {environment['system']}",
        f"{versions}; commit {environment['commit']}, {data['created']}",
        f"truth by {' or '.join(map(str, rays))} rays per pixel and light",
    ]
    return "\n".join(f"- {entry}" for entry in entries)


# -- Charts ------------------------------------------------------------------------------------------------------------


def _error_against_time(pictures: Sequence[Picture]) -> Series:
    """A series per technique with its options, or without where these are more than colours."""
    labels = {row["label"] for picture in pictures for row in picture["techniques"]}
    key = "label" if len(labels) <= MOST_SERIES else "name"
    series: dict[str, list[Mark]] = {}
    for picture in pictures:
        for row in picture["techniques"]:
            rmse = mean(row, "rmse")
            says = f"{row['label']} on {picture['scene']}: {row['frame_ms']:.1f} ms, rmse {rmse:.4f}"
            series.setdefault(row[key], []).append(Mark(row["frame_ms"], max(rmse, LEAST_RMSE), says))
    return series


def _growth(suite: str, pictures: Sequence[Picture], charts: dict[str, str]) -> list[str]:
    """For everything that grows: time and memory as charts, then the numbers."""
    parts = []
    for axis in dict.fromkeys(picture["figures"]["axis"] for picture in pictures):
        along = [picture for picture in pictures if picture["figures"]["axis"] == axis]
        parts.append(f"### {axis}")
        for what, unit, value in (
            ("time", "ms per frame", lambda row: row["frame_ms"]),
            ("memory", "MiB", lambda row: row["gpu_bytes"] / MEBIBYTE),
        ):
            name = f"{file_stem(suite)}-{file_stem(axis)}-{what}.svg"
            charts[name] = chart(_over(along, value), axis, unit, joined=True)
            parts.append(_image(name, f"{what} over {axis}"))
        rows = [[picture["scene"], *_cells(row)] for picture in along for row in picture["techniques"]]
        parts.append(table(["picture", *(heading for heading, _ in COLUMNS)], rows))
    return parts


def _over(pictures: Sequence[Picture], value: Callable[[Row], float]) -> Series:
    series: dict[str, list[Mark]] = {}
    for picture in pictures:
        for row in picture["techniques"]:
            amount = row["figures"]["amount"]
            says = f"{row['label']}, {amount}: {value(row):.4g}"
            series.setdefault(row["figures"]["series"], []).append(Mark(amount, value(row), says))
    return series


def _image(name: str, says: str) -> str:
    return f"![{says}]({(IMAGES / name).as_posix()})"


# -- Tables ------------------------------------------------------------------------------------------------------------


def mean(row: Row, figure: str) -> float:
    """A figure of metrics.Comparison, as the mean over the lights."""
    return sum(light[figure] for light in row["lights"]) / max(len(row["lights"]), 1)


def milliseconds(value: float) -> str:
    """Three digits, which is what a time is good for."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"


def timed(row: Row) -> str:
    """The median and the spread of a frame's time."""
    time = row["times"]["frame"]
    return f"{milliseconds(row['frame_ms'])} ({milliseconds(time['fastest_ms'])}–{milliseconds(time['slowest_ms'])})"


COLUMNS: list[tuple[str, Callable[[Row], str]]] = [
    ("technique", lambda row: f"`{row['label']}`"),
    ("ms", timed),
    ("rmse", lambda row: f"{mean(row, 'rmse'):.4f}"),
    ("leaks", lambda row: f"{mean(row, 'leak_rate'):.2%}"),
    ("false shadow", lambda row: f"{mean(row, 'false_shadow_rate'):.2%}"),
    ("maps", lambda row: f"{row['shadow_maps']}"),
    ("look-ups", lambda row: f"{row['lookups_per_pixel']:.1f}"),
    ("MiB", lambda row: f"{row['gpu_bytes'] / MEBIBYTE:.0f}"),
]
"""Columns of a table of techniques: the heading, and what of a row stands below."""
ABOUT = "about"
"""A figure that is a sentence, which stands below the table: what a peer does."""
UNKNOWN = ("maps", "look-ups", "MiB")
"""What nobody counts of a peer."""


def _cells(row: Row) -> list[str]:
    hidden = UNKNOWN if ABOUT in row["figures"] else ()
    return ["–" if heading in hidden else cell(row) for heading, cell in COLUMNS]


def _is_matrix(pictures: Sequence[Picture]) -> bool:
    """Whether all pictures show the same techniques, and nothing beyond the errors."""
    labels = [[row["label"] for row in picture["techniques"]] for picture in pictures]
    plain = not any(row["figures"] for picture in pictures for row in picture["techniques"])
    return plain and len(pictures) > 2 and all(each == labels[0] for each in labels)


def _matrices(pictures: Sequence[Picture]) -> list[str]:
    """Pictures down, techniques across: errors, then times."""
    labels = [f"`{row['label']}`" for row in pictures[0]["techniques"]]
    parts = []
    for title, cell in (("rmse", lambda row: f"{mean(row, 'rmse'):.4f}"), ("ms", timed)):
        rows = [
            [f"{picture['scene']}, {picture['triangles']:,} triangles", *map(cell, picture["techniques"])]
            for picture in pictures
        ]
        parts.append(table([title, *labels], rows))
    return parts


def _tables(pictures: Sequence[Picture]) -> list[str]:
    """A table per picture, and one of what the suite measures beyond the errors."""
    parts = []
    for picture in pictures:
        width, height = picture["size"]
        kinds = " and ".join(dict.fromkeys(light["type"] for light in picture["lights"]))
        parts.append(f"### {picture['scene']}")
        parts.append(f"{width}×{height}, {picture['triangles']:,} triangles, {kinds} light.")
        parts.append(table([heading for heading, _ in COLUMNS], [_cells(row) for row in picture["techniques"]]))
        parts += _figures(picture["techniques"])
        parts += _of_the_picture(picture["figures"])
    return parts


def _figures(rows: Sequence[Row]) -> list[str]:
    given = [item for row in rows for item in row["figures"].items()]
    nested = {name for name, value in given if isinstance(value, dict)}
    names = [name for name in dict.fromkeys(name for name, _ in given) if name not in nested | {ABOUT}]
    parts = []
    if names:
        cells = [[f"`{row['label']}`", *(_figure(row["figures"].get(name)) for name in names)] for row in rows]
        parts.append(table(["technique", *(name.replace("_", " ") for name in names)], cells))
    said = [row for row in rows if ABOUT in row["figures"]]
    if said:
        parts.append("\n".join(f"- **{row['label']}** ({_options(row)}): {row['figures'][ABOUT]}" for row in said))
    return parts


def _of_the_picture(figures: dict[str, Any]) -> list[str]:
    """What a suite measures of the picture itself, where it is a number."""
    rows = [
        [name.replace("_", " "), _figure(value)] for name, value in figures.items() if isinstance(value, int | float)
    ]
    return [table(["of the picture", ""], rows)] if rows else []


def _options(row: Row) -> str:
    return ", ".join(f"{name} {value}" for name, value in row["options"].items())


def _figure(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.3g}"


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, all but the first column to the right."""
    lines = [headings, ["---", *["---:"] * (len(headings) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
