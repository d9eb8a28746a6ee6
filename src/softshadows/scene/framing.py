"""A camera and a light for a scene that names none, so that any model file makes a picture at once."""

from __future__ import annotations

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.camera import Camera
from softshadows.scene.geometry import Geometry, flatten
from softshadows.scene.lights import RectLight
from softshadows.scene.model import Scene
from softshadows.scene.vectors import VectorLike

WELL_LIT = 4.0
"""Irradiance in W/m² at which a mid-grey surface looks well exposed after the display transform."""

VIEW = np.array([0.62, 0.42, 0.66])
"""From the scene's centre to the default camera: three quarters from the right, a little above."""

LAMP_DEPTH = 0.75
"""Where the default light of a closed room hangs, as a share of the way from the camera to what it looks at."""

LIGHT = np.array([0.35, 0.85, 0.25])
"""From the scene's centre to the default light: high, on the camera's right."""


def complete(scene: Scene, *, aspect: float = 4.0 / 3.0) -> list[str]:
    """Give `scene` a camera and a light where it has none; returns one sentence for each that was added.

    `aspect` is the picture's width divided by its height. Raises SceneError (SCENE_EMPTY) for a scene
    without extent.
    """
    notes = []
    is_placed = scene.camera is not None or bool(scene.cameras)  # by someone, perhaps indoors
    if scene.camera is None:
        scene.camera = scene.cameras[0] if scene.cameras else framing_camera(scene, aspect=aspect)
        if not scene.cameras:
            notes.append("no camera given: using a three-quarter view of the whole scene (set one with --camera)")
    if not scene.lights:
        lamp = ceiling_light(scene, scene.camera) if is_placed else None
        scene.lights = [lamp or framing_light(scene)]
        where = "below the ceiling" if lamp else "above the scene"
        notes.append(f"no light given: using a square area light {where} (set one with --light)")
    return notes


def framing_camera(scene: Scene, *, aspect: float = 4.0 / 3.0, vertical_fov: float = 40.0) -> Camera:
    """A three-quarter view that holds all of the scene but its ground, with a small margin."""
    center, points, diagonal = _box(scene)
    camera = Camera(tuple(center + VIEW * diagonal), tuple(center), vertical_fov)
    right, up, back = camera.axes
    offset = points - center
    tangent = np.tan(np.radians(vertical_fov) / 2.0) * 0.92  # the margin
    # A point is in view from distance d along `back` where |sideways| ≤ tangent · (d − nearness).
    needed_up = np.abs(offset @ up) / tangent + offset @ back
    needed_right = np.abs(offset @ right) / (tangent * aspect) + offset @ back
    distance = max(needed_up.max(), needed_right.max())
    return Camera(tuple(center + back * distance), tuple(center), vertical_fov)


def framing_light(scene: Scene) -> RectLight:
    """A square light above the scene, 0.4 bounding-box diagonals wide, that lights the scene's centre well."""
    center, _, diagonal = _box(scene)
    position = center + LIGHT / np.linalg.norm(LIGHT) * 1.5 * diagonal
    return rect_light(position, center, 0.4 * diagonal, 0.4 * diagonal)


def ceiling_light(scene: Scene, camera: Camera) -> RectLight | None:
    """A square light just below the ceiling, between `camera` and what it looks at; None where the view has no ceiling.

    It lights the floor below it well. A light above the scene would leave a closed room black.
    """
    geometry = flatten(scene)
    position, back = np.array(camera.position), camera.axes[2]
    depth = _distance(geometry, position, -back)
    if not np.isfinite(depth):
        return None
    below, up = position - back * depth * LAMP_DEPTH, np.array([0.0, 1.0, 0.0])
    ceiling, floor = _distance(geometry, below, up), _distance(geometry, below, -up)
    if not np.isfinite(ceiling + floor):
        return None
    side = 0.25 * (ceiling + floor)
    return rect_light(below + up * 0.9 * ceiling, below - up * floor, side, side)


def _distance(geometry: Geometry, start: np.ndarray, direction: np.ndarray) -> float:
    """From `start` to the first opaque triangle along the unit `direction`, metres; inf where there is none."""
    sideways = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    frame = np.stack([sideways, np.cross(direction, sideways), direction], axis=1)
    seen = (geometry.positions - start) @ frame  # the ray is the third axis
    triangles = geometry.triangles[: geometry.opaque_count].astype(np.intp)
    u, v = (axis.take(triangles) for axis in (seen[:, 0], seen[:, 1]))
    near = (u.min(axis=1) <= 0.0) & (u.max(axis=1) >= 0.0) & (v.min(axis=1) <= 0.0) & (v.max(axis=1) >= 0.0)
    u, v, along = u[near], v[near], seen[:, 2].take(triangles[near])
    # The ray passes inside where it turns the same way about all three edges.
    turns = np.roll(u, -1, axis=1) * np.roll(v, -2, axis=1) - np.roll(u, -2, axis=1) * np.roll(v, -1, axis=1)
    total = turns.sum(axis=1)
    inside = ((turns >= 0.0).all(axis=1) | (turns <= 0.0).all(axis=1)) & (total != 0.0)
    hits = (turns[inside] * along[inside]).sum(axis=1) / total[inside]
    return float(hits[hits > 0.0].min(initial=np.inf))


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
    """Middle and diagonal of the box around what is to be framed, all but a ground plane, and its vertices (n, 3)."""
    points = flatten(Scene([node for node in scene.nodes if node.name != "ground"] or scene.nodes)).positions
    if not len(points):
        raise SceneError("the scene has no vertices: give a camera and a light", code="SCENE_EMPTY")
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    diagonal = float(np.linalg.norm(high - low))
    if not diagonal > 0.0:
        raise SceneError("the scene is a single point: give a camera and a light", code="SCENE_EMPTY")
    return (low + high) / 2.0, points.astype(np.float64), diagonal
