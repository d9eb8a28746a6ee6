"""A compare report: `index.html` with everything in it, `results.json`, and the pictures as files."""

from __future__ import annotations

import re
from pathlib import Path

from softshadows.report.measure import Measurement
from softshadows.report.page import page
from softshadows.report.plates import plates
from softshadows.report.results import results, write_bytes, write_json


def write_report(measurement: Measurement, folder: Path) -> Path:
    """Write the report of `measurement` into `folder` and return the path of its page.

    Raises OptionError where the folder cannot be written.
    """
    shown = plates(measurement)
    data = results([measurement])
    for label, pictures in shown.items():
        for caption, image in pictures:
            write_bytes(image, folder / "images" / f"{file_stem(label)}-{file_stem(caption)}.png")
    write_json(data, folder / "results.json")
    index = folder / "index.html"
    write_bytes(page(measurement, shown, data).encode(), index)
    return index


def file_stem(text: str) -> str:
    """`text` as part of a file name: letters, digits, dots and dashes."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", text).strip("-.") or "x"
