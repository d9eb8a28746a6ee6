"""Real models from file to picture: scans, masks, thin parts, a room with a camera of its own, a shot.

benchmarks/real_scenes.py does the same for whole folders, with pictures to look at.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import softshadows as ss
from softshadows.scene.shot import open_shot

SOURCES = (
    "stanford_bunny/stanford_bunny.glb",
    "armadillo/armadillo.obj",
    "dutch_ship/dutch_ship.glb",
    "alpha_blend_mode_test/alpha_blend_mode_test.glb",
    "cornell_box_nv/cornell_box_nv.glb",
    "japanese_classroom/japanese_classroom.glb",
    "shots/bike_line.toml",
)


@pytest.mark.scenes
@pytest.mark.parametrize("source", SOURCES)
def test_a_real_scene_makes_a_sound_picture(scenes_folder: Path, source: str) -> None:
    shot = open_shot(scenes_folder / source, size=(96, 72))
    for technique in (ss.techniques.Pcss(), ss.techniques.Uniform(grid=3)):
        frame = ss.render(shot.scene, shot.camera, technique=technique, size=shot.size)
        assert np.isfinite(frame.color).all()
        assert ((frame.visibility >= 0.0) & (frame.visibility <= 1.0)).all()
        assert frame.surface.mean() > 0.02
        lit = frame.color[frame.surface].max(axis=1) > 0.0
        assert lit.mean() > 0.2, "most of what is seen is black"
        assert frame.visibility[:, frame.surface].std() > 0.02, "no shadow anywhere"
