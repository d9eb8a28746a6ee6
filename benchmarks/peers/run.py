"""Other renderers beside softshadows: the same scene, camera and size, errors against the same truth, times in one run.

    python benchmarks/peers/run.py --peers ~/softshadows-peers --json benchmarks/results/peers.json

Scenes: `figures`, and the shot `scorpion` where $SOFTSHADOWS_SCENES is set. README.md says what to install for each
peer; those that are not there are named and left out. Every peer is a program of its own: it gets a folder (subject.py)
and leaves the visibility of each pixel, float32, row 0 at the top, and the wall times of its frames. Where a peer tries
several settings, the one with the least rmse is its row.

The JSON is a results.json (src/softshadows/compare/results.py); peers are rows without options of ours.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from subject import write_subject

import softshadows as ss
from softshadows.compare.interleaved import Timing, render_interleaved
from softshadows.compare.measure import Measurement, reference_frame
from softshadows.compare.results import results, write_json
from softshadows.scene.shot import Shot, open_shot
from softshadows.techniques import Technique, make_technique

HERE = Path(__file__).parent
SIZE = (512, 384)
EMBREE_RAYS = (16, 64, 289)
SEED = 1
"""Not the truth's, whose errors would be the same."""
MINUTES = 15
"""The most a peer may take."""


def techniques() -> list[Technique]:
    """Those of ours that a reader would choose from for a rectangle light."""
    return [
        make_technique("pcss"),
        make_technique("variable_penumbra", {"kernels": "from_light"}),
        make_technique("uniform"),
        make_technique("adaptive"),
        make_technique("penumbra_wedges"),
    ]


def shots(size: tuple[int, int]) -> Iterator[Shot]:
    """A built-in scene, and a real one where it is at hand."""
    yield replace(open_shot("figures"), size=size)
    folder = os.environ.get("SOFTSHADOWS_SCENES")
    if folder:
        yield replace(open_shot(str(Path(folder, "shots", "scorpion.toml"))), size=size)


def commands(peers: Path) -> dict[str, list[str]]:
    """How each peer is started; README.md says how it comes to be there."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome") or "chromium"
    return {
        "mitsuba": [str(peers / "mitsuba/bin/python"), str(HERE / "mitsuba_rays.py")],
        "pygfx": [str(peers / "pygfx/bin/python"), str(HERE / "pygfx_shadows.py")],
        "three": ["node", str(HERE / "three_shadows.mjs"), str(peers / "three/node_modules"), chromium],
    }


def run_peer(name: str, command: list[str], folder: Path, variables: dict[str, str]) -> list[dict[str, Any]] | str:
    """The rows that a peer leaves, or in a sentence why it does not."""
    if shutil.which(command[0]) is None:
        return f"{name}: {command[0]} is not there; benchmarks/peers/README.md says what to install"
    try:
        done = subprocess.run(
            [*command, str(folder)],
            env={**os.environ, **variables},
            capture_output=True,
            text=True,
            timeout=60 * MINUTES,
        )
    except subprocess.TimeoutExpired:
        return f"{name}: not done after {MINUTES} minutes"
    if done.returncode:
        return f"{name}: {' '.join(done.stderr.split())[-300:] or f'exit code {done.returncode}'}"
    return json.loads((folder / f"{name}.json").read_text())


def peer_row(rows: list[dict[str, Any]], measured: Measurement, folder: Path) -> dict[str, Any]:
    """The row of the setting with the least rmse, as results.json has it."""
    width, height = measured.shot.size
    truth, mask = measured.reference.visibility[0], measured.reference.mask[0]

    def comparison(row: dict[str, Any]) -> ss.metrics.Comparison:
        visibility = np.fromfile(folder / row["visibility"], np.float32).reshape(height, width)
        return ss.metrics.compare(visibility, truth, mask=mask)

    best = min(rows, key=lambda row: comparison(row).rmse)
    return as_row(best, comparison(best))


def as_row(row: dict[str, Any], comparison: ss.metrics.Comparison) -> dict[str, Any]:
    timing = Timing.of(row["milliseconds"])
    return {
        "label": row["label"],
        "name": row["name"],
        "options": {"version": row["version"], **row["options"]},
        "shadow_maps": 0,
        "lookups_per_pixel": 0.0,
        "frame_ms": timing.median_ms,
        "times": {"frame": asdict(timing)},
        "gpu_ms": {},
        "cpu_ms": 0.0,
        "gpu_bytes": 0,
        "flip": None,
        "warnings": [],
        "figures": {"about": row["about"]},
        "lights": [comparison.as_dict()],
    }


def embree_rows(shot: Shot, frame: ss.Frame, measured: Measurement, repeats: int) -> Iterator[dict[str, Any]]:
    """The tracer of the truth with fewer rays and other random numbers; primary rays are not part of its time."""
    from importlib.metadata import version

    for samples in EMBREE_RAYS:
        milliseconds = []
        visibility = np.zeros(0)
        for turn in range(repeats):
            started = time.perf_counter()
            visibility = ss.truth.visibility(shot.scene, frame, samples=samples, seed=SEED + turn)
            milliseconds.append(1e3 * (time.perf_counter() - started))
        row = {
            "label": f"Embree, {samples} rays",
            "name": "embree",
            "version": version("embreex"),
            "about": "the tracer of the truth with fewer rays and other random numbers, from given surface points.",
            "options": {"samples": samples},
            "milliseconds": milliseconds,
        }
        reference = measured.reference
        yield as_row(row, ss.metrics.compare(visibility[0], reference.visibility[0], mask=reference.mask[0]))


def measure(shot: Shot, peers: Path, drivers: dict[str, str], samples: int, repeats: int) -> dict[str, Any]:
    """One picture of results.json: our techniques, then the peers."""
    base = reference_frame(shot, samples, lambda doing, share: print(f"{shot.name}: {doing}", flush=True))
    runs, failed = render_interleaved(shot, techniques(), repeats, lambda doing, share: None)
    measured = Measurement(shot, base.reference, [base.result_of(run) for run in runs], failed)
    rows, missing = list(embree_rows(shot, base.frame, measured, repeats)), []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_subject(shot, base.frame, repeats, folder)
        for name, command in commands(peers).items():
            print(f"{shot.name}: {name}", flush=True)
            driver = {"VK_ICD_FILENAMES": drivers[name]} if name in drivers else {}
            found = run_peer(name, command, folder, driver)
            if isinstance(found, str):
                missing.append(found)
                continue
            kinds = [
                [row for row in found if row["label"] == label] for label in dict.fromkeys(r["label"] for r in found)
            ]
            rows += [peer_row(kind, measured, folder) for kind in kinds]
    (picture,) = results([measured], suite="peers")["pictures"]
    picture["techniques"] += rows
    picture["skipped"] += missing
    return picture


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--peers", type=Path, default=Path.home() / "softshadows-peers", help="where they are installed"
    )
    parser.add_argument("--json", type=Path, default=Path("peers.json"))
    parser.add_argument("--size", default="{}x{}".format(*SIZE))
    parser.add_argument("--samples", type=int, default=1024, help="rays per pixel of the truth")
    parser.add_argument("--repeats", type=int, default=5, help="timed frames of everything")
    parser.add_argument("--pygfx-driver", help="a Vulkan driver's JSON file for pygfx, where ours does not serve it")
    arguments = parser.parse_args()
    drivers = {"pygfx": arguments.pygfx_driver} if arguments.pygfx_driver else {}
    width, height = map(int, arguments.size.split("x"))
    pictures = [
        measure(shot, arguments.peers, drivers, arguments.samples, arguments.repeats) for shot in shots((width, height))
    ]
    write_json({**results([], suite="peers"), "pictures": pictures}, arguments.json)
    for picture in pictures:
        print(picture["scene"])
        for row in picture["techniques"]:
            print(f"  {row['label']:45}{row['frame_ms']:9.0f} ms  rmse {row['lights'][0]['rmse']:.4f}")
        for sentence in picture["skipped"]:
            print(f"  {sentence}")
    return int(any(picture["skipped"] for picture in pictures))


if __name__ == "__main__":
    sys.exit(main())
