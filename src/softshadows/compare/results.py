"""results.json: what was measured, on what, as plain data with a schema that stays.

schema        "softshadows-results/1": fields may be added to it, none is renamed or removed
created       ISO 8601, UTC
environment   adapter (name, driver, features, limits), cpu, system, versions, commit
suite         the suite's name, or None
pictures      one per shot: scene, size, triangles, camera, lights, truth (samples, standard_error, seconds),
              techniques (label, name, options, shadow_maps, lookups_per_pixel, frame_ms, times, gpu_ms by pass,
              cpu_ms, gpu_bytes, flip, warnings, figures, lights: one Comparison each), skipped, figures
times         wall times of interleaved frames, by what was asked of them ("frame": the one in frame_ms), each with
              median_ms, fastest_ms, slowest_ms and the number of frames
figures       what the suite measures beyond that, of a technique or of the picture; its module says what
"""

from __future__ import annotations

import dataclasses
import datetime
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from softshadows.compare.environment import environment
from softshadows.compare.measure import Measurement, Result
from softshadows.errors import OptionError
from softshadows.image.files import replace_file
from softshadows.scene.lights import Light
from softshadows.techniques.options import values_of

SCHEMA = "softshadows-results/1"


def results(measurements: Sequence[Measurement], *, suite: str | None = None) -> dict[str, Any]:
    """All measurements of one run as plain data."""
    return {
        "schema": SCHEMA,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "environment": environment(),
        "suite": suite,
        "pictures": [_picture(measurement) for measurement in measurements],
    }


def write_json(data: dict[str, Any], path: Path) -> None:
    """Write `data` to `path`; OptionError where that cannot be."""
    write_bytes((json.dumps(data, indent=2) + "\n").encode(), path)


def write_bytes(data: bytes, path: Path) -> None:
    """Write a file whole or not at all, making its folder first; OptionError saying why where that cannot be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda part: part.write_bytes(data))
    except OSError as error:
        raise OptionError(f"{path} cannot be written: {error.strerror or error}") from error


def _picture(measurement: Measurement) -> dict[str, Any]:
    shot, reference = measurement.shot, measurement.reference
    return {
        "scene": shot.name,
        "size": list(shot.size),
        "triangles": shot.scene.triangle_count,
        "camera": dataclasses.asdict(shot.camera),
        "lights": [_light(light) for light in shot.scene.lights],
        "truth": {
            "samples": reference.samples,
            "standard_error": reference.standard_error,
            "seconds": reference.seconds,
        },
        "techniques": [_technique(result) for result in measurement.results],
        "skipped": measurement.skipped,
        "figures": measurement.figures,
    }


def _light(light: Light) -> dict[str, Any]:
    return {"type": light.kind, **dataclasses.asdict(light)}


def _technique(result: Result) -> dict[str, Any]:
    return {
        "label": result.label,
        "name": result.technique.name,
        "options": values_of(result.technique),
        "frame_ms": result.frame_ms,
        "times": {name: dataclasses.asdict(timing) for name, timing in result.times.items()},
        **result.stats,
        "flip": result.flip,
        "warnings": result.warnings,
        "figures": result.figures,
        "lights": [comparison.as_dict() for comparison in result.comparisons],
    }
