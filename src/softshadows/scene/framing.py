"""A camera and a light for a scene that names none, so that any model file makes a picture at once."""

from __future__ import annotations

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.camera import Camera
from softshadows.scene.lights import RectLight
from softshadows.scene.model import Scene
from softshadows.scene.vectors import VectorLike

WELL_LIT = 4.0
"""Irradiance in W/m² at which a mid-grey surface looks well exposed after the display transform."""

VIEW = np.array([0.62, 0.42, 0.66])
"""From the scene's centre to the default camera: three quarters from the right, a little above."""

LIGHT = np.array([0.35, 0.85, 0.25])
"""From the scene's centre to the default light: high, on the camera's right."""


def complete(scene: Scene, *, aspect: float = 4.0 / 3.0) -> list[str]:
    """Give `scene` a camera and a light where it has none; returns one sentence for each that was added.

    `aspect` is the picture's width divided by its height. Raises SceneError (SCENE_EMPTY) for a scene
    without extent.
    """
    notes = []
    if scene.camera is None:
        scene.camera = scene.cameras[0] if scene.cameras else framing_camera(scene, aspect=aspect)
        if not scene.cameras:
            notes.append("no camera given: using a three-quarter view of the whole scene (set one with --camera)")
    if not scene.lights:
        scene.lights = [framing_light(scene)]
        notes.append("no light given: using a square area light above the scene (set one with --light)")
    return notes


def framing_camera(scene: Scene, *, aspect: float = 4.0 / 3.0, vertical_fov: float = 40.0) -> Camera:
    """A three-quarter view that holds the scene's bounding box, with a small margin."""
    center, corners, diagonal = _box(scene)
    camera = Camera(tuple(center + VIEW * diagonal), tuple(center), vertical_fov)
    right, up, back = camera.axes
    offset = corners - center
    tangent = np.tan(np.radians(vertical_fov) / 2.0) * 0.92  # the margin
    # A corner is in view from distance d along `back` where |sideways| ≤ tangent · (d − nearness).
    needed_up = np.abs(offset @ up) / tangent + offset @ back
    needed_right = np.abs(offset @ right) / (tangent * aspect) + offset @ back
    distance = max(needed_up.max(), needed_right.max())
    return Camera(tuple(center + back * distance), tuple(center), vertical_fov)


def framing_light(scene: Scene) -> RectLight:
    """A square light above the scene, 0.4 bounding-box diagonals wide, that lights the scene's centre well."""
    center, _, diagonal = _box(scene)
    position = center + LIGHT / np.linalg.norm(LIGHT) * 1.5 * diagonal
    return rect_light(position, center, 0.4 * diagonal, 0.4 * diagonal)


def rect_light(
    position: VectorLike, target: VectorLike, width: float, height: float, *, irradiance: float = WELL_LIT
) -> RectLight:
    """A white rectangle light whose radiance gives about `irradiance` (W/m²) on a surface at `target` that faces it."""
    distance_squared = float(np.sum(np.subtract(target, position) ** 2))
    radiance = irradiance * (distance_squared + width * height / np.pi) / (width * height)
    return RectLight(_triple(position), _triple(target), width, height, (radiance, radiance, radiance))


def _triple(value: VectorLike) -> tuple[float, float, float]:
    x, y, z = (float(component) for component in value)
    return (x, y, z)


def _box(scene: Scene) -> tuple[np.ndarray, np.ndarray, float]:
    """Centre (3,), corners (8, 3) and diagonal of the box around what is to be framed: all but a ground plane."""
    without_ground = Scene([node for node in scene.nodes if node.name != "ground"] or scene.nodes)
    low, high = without_ground.bounds().astype(np.float64)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    diagonal = float(np.linalg.norm(high - low))
    if not diagonal > 0.0:
        raise SceneError("the scene is a single point: give a camera and a light", code="SCENE_EMPTY")
    return (low + high) / 2.0, corners, diagonal
