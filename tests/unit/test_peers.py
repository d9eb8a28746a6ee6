"""benchmarks/peers: what a peer is given, which of its settings is shown, and that a missing one is named."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import softshadows as ss
from softshadows.compare.measure import Measurement, reference_frame
from softshadows.compare.schema import TECHNIQUE, check
from softshadows.scene.shot import open_shot

PEERS = Path(__file__).parents[2] / "benchmarks" / "peers"
SIZE = (32, 24)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """benchmarks/peers/run.py as a module."""
    monkeypatch.syspath_prepend(str(PEERS))
    monkeypatch.delitem(sys.modules, "run", raising=False)
    import run  # type: ignore[import-not-found]

    return run


def test_a_peer_gets_the_whole_scene(run: ModuleType, tmp_path: Path) -> None:
    shot = replace(open_shot("blocker"), size=SIZE)
    frame = ss.render(shot.scene, shot.camera, technique="none", size=SIZE)
    run.write_subject(shot, frame, 3, tmp_path)
    loaded = ss.load_scene(tmp_path / "scene.glb")
    assert loaded.triangle_count == shot.scene.triangle_count
    np.testing.assert_allclose(loaded.bounds(), shot.scene.bounds(), atol=1e-6)
    assert len(np.load(tmp_path / "triangles.npz")["triangles"]) == shot.scene.triangle_count
    subject = json.loads((tmp_path / "subject.json").read_text())
    assert (subject["size"], subject["repeats"]) == ([32, 24], 3)
    light = subject["light"]
    assert light["center"] == [0.0, 10.0, 0.0]
    assert light["half_extent"] == [1.0, 1.0]
    np.testing.assert_allclose(light["axes"][2], [0.0, 1.0, 0.0], atol=1e-12)
    toward = frame.position[frame.facing[0]] - np.array(light["center"])
    angles = np.degrees(np.arccos(-toward[:, 1] / np.linalg.norm(toward, axis=1)))
    assert light["cone_degrees"] == pytest.approx(angles.max(), abs=1e-4)
    near, far = light["range"]
    assert near == pytest.approx(0.9 * 6.0)  # the card, 6 m below the light
    assert far == pytest.approx(10.0)


def test_the_setting_with_the_least_error_is_shown(run: ModuleType, tmp_path: Path) -> None:
    shot = replace(open_shot("blocker"), size=SIZE)
    base = reference_frame(shot, 64, lambda doing, share: None)
    truth = base.reference.visibility[0]
    rows = []
    for index, wrong in enumerate((0.3, 0.1, 0.2)):
        (truth * np.float32(1.0 - wrong)).tofile(tmp_path / f"{index}.f32")
        row = {"label": "p", "name": "p", "version": "1", "about": "a peer", "milliseconds": [3.0, 1.0, 2.0]}
        rows.append({**row, "options": {"bias": index}, "visibility": f"{index}.f32"})
    row = run.peer_row(rows, Measurement(shot, base.reference, []), tmp_path)
    check(row, TECHNIQUE)
    assert row["options"] == {"version": "1", "bias": 1}
    assert row["times"]["frame"] == {"median_ms": 2.0, "fastest_ms": 1.0, "slowest_ms": 3.0, "frames": 3}
    assert row["lights"][0]["max"] == pytest.approx(0.1, abs=1e-6)


def test_a_peer_that_is_missing_or_fails_is_named(run: ModuleType, tmp_path: Path) -> None:
    commands = run.commands(tmp_path)
    assert "README.md says what to install" in run.run_peer("pygfx", commands["pygfx"], tmp_path, {})
    failing = [sys.executable, "-c", "import sys; sys.exit('no driver')"]
    assert run.run_peer("pygfx", failing, tmp_path, {}) == "pygfx: no driver"
