"""What every peer is given: a folder with the triangles, the same as a GLB, and camera, light and size as JSON.

    subject.json     size [width, height]; repeats; camera {position, axes (rows right, up, back), vertical_fov, range};
                     light {center, axes, half_extent, cone_degrees, range}
    triangles.npz    positions (n, 3) float32, triangles (m, 3) uint32, world space, metres
    scene.glb        the same triangles

`cone_degrees` is the half opening of a spot light in the light's middle that reaches all that faces the light in view,
at most WIDEST. Ranges are depths: all that camera or light sees lies between.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import trimesh

import softshadows as ss
from softshadows.scene.geometry import flatten
from softshadows.scene.shot import Shot

WIDEST = 60.0
"""Degrees. Beyond it a spot light's map has few texels in the middle."""

NEAR = 0.9
"""Share of the depth of the nearest vertex in front of the light."""


def write_subject(shot: Shot, frame: ss.Frame, repeats: int, folder: Path) -> None:
    """Prepare `folder` for a shot with one rectangle light; `frame` says what is in view."""
    (light,) = shot.scene.lights
    geometry = flatten(shot.scene)
    if geometry.opaque_count != len(geometry.triangles):
        raise SystemExit(f"{shot.name} has surfaces with holes in their texture, which not every peer knows")
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "triangles.npz", positions=geometry.positions, triangles=geometry.triangles)
    mesh = trimesh.Trimesh(geometry.positions, geometry.triangles, process=False)
    (folder / "scene.glb").write_bytes(trimesh.Scene(mesh).export(file_type="glb"))  # type: ignore[arg-type]

    toward = frame.position[frame.facing[0]] - light.center
    forward = toward @ -light.axes[2]
    cone = np.degrees(np.arccos(np.clip(forward / np.linalg.norm(toward, axis=1), -1.0, 1.0)).max())
    depths = (geometry.positions - light.center) @ -light.axes[2]
    subject = {
        "size": list(shot.size),
        "repeats": repeats,
        "camera": {
            "position": shot.camera.position,
            "axes": shot.camera.axes.tolist(),
            "vertical_fov": shot.camera.vertical_fov,
            "range": [1e-3 * geometry.diagonal, 2.0 * geometry.diagonal],
        },
        "light": {
            "center": light.center.tolist(),
            "axes": light.axes.tolist(),
            "half_extent": light.half_extent,
            "cone_degrees": float(min(cone, WIDEST)),
            "range": [NEAR * float(depths[depths > 0.0].min()), float(depths.max())],
        },
    }
    (folder / "subject.json").write_text(json.dumps(subject, indent=1) + "\n")
