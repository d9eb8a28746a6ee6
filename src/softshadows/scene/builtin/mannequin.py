"""A figure over a floor: the kind of scene that mobile games are made of, after Evans et al. 2014."""

from __future__ import annotations

import numpy as np

from softshadows.scene.builtin import shapes
from softshadows.scene.camera import Camera
from softshadows.scene.framing import rect_light
from softshadows.scene.model import Material, Node, Scene

FLOOR = Material("floor", (0.72, 0.70, 0.66, 1.0), roughness=0.95)
WOOD = Material("wood", (0.66, 0.47, 0.28, 1.0), roughness=0.6)
SEGMENTS = 112
"""Around each limb: fine enough for more than 50 000 vertices in all, as the paper's model has."""
RINGS = 28
"""Along each limb."""

LIMBS: tuple[tuple[str, tuple[float, float, float], tuple[float, float, float], float, float], ...] = (
    # name, joint, joint, radius at each of them; metres, feet on the floor, facing +z
    ("pelvis", (-0.07, 0.93, 0.0), (0.07, 0.93, 0.0), 0.11, 0.11),
    ("waist", (0.0, 0.95, 0.0), (0.0, 1.12, 0.0), 0.11, 0.10),
    ("chest", (0.0, 1.15, 0.0), (0.0, 1.36, 0.0), 0.13, 0.15),
    ("shoulders", (-0.16, 1.42, 0.0), (0.16, 1.42, 0.0), 0.07, 0.07),
    ("neck", (0.0, 1.42, 0.0), (0.0, 1.56, 0.01), 0.055, 0.05),
    ("head", (0.0, 1.63, 0.02), (0.0, 1.71, 0.02), 0.085, 0.10),
    ("left upper arm", (0.20, 1.42, 0.0), (0.46, 1.36, 0.05), 0.055, 0.045),
    ("left forearm", (0.46, 1.36, 0.05), (0.66, 1.50, 0.17), 0.045, 0.032),
    ("left hand", (0.68, 1.52, 0.18), (0.75, 1.59, 0.22), 0.035, 0.022),
    ("right upper arm", (-0.20, 1.42, 0.0), (-0.30, 1.15, -0.03), 0.055, 0.045),
    ("right forearm", (-0.30, 1.15, -0.03), (-0.28, 0.91, 0.10), 0.045, 0.032),
    ("right hand", (-0.28, 0.88, 0.12), (-0.27, 0.80, 0.16), 0.035, 0.022),
    ("left thigh", (0.10, 0.90, 0.0), (0.14, 0.50, 0.05), 0.085, 0.06),
    ("left shin", (0.14, 0.50, 0.05), (0.15, 0.10, -0.02), 0.06, 0.04),
    ("left foot", (0.15, 0.045, -0.04), (0.18, 0.035, 0.16), 0.045, 0.034),
    ("right thigh", (-0.10, 0.90, 0.0), (-0.13, 0.50, 0.02), 0.085, 0.06),
    ("right shin", (-0.13, 0.50, 0.02), (-0.14, 0.10, -0.10), 0.06, 0.04),
    ("right foot", (-0.14, 0.045, -0.12), (-0.17, 0.035, 0.08), 0.045, 0.034),
)


def limb(start: tuple[float, ...], end: tuple[float, ...], start_radius: float, end_radius: float) -> shapes.Solid:
    """A round bar between two joints, thicker or thinner along its way, with a half ball at each end."""
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    length = float(np.linalg.norm(b - a))
    quarter = np.linspace(0.0, np.pi / 2.0, RINGS // 3 + 1)
    foot = np.column_stack([start_radius * np.sin(quarter), -start_radius * np.cos(quarter)])
    top = np.column_stack([end_radius * np.cos(quarter), length + end_radius * np.sin(quarter)])
    along = np.linspace(0.0, 1.0, RINGS // 3 + 2)[1:-1, None]
    profile = np.concatenate([foot, (1.0 - along) * foot[-1] + along * top[0], top])
    profile[[0, -1], 0] = 0.0  # poles
    solid = shapes.lathe(profile, SEGMENTS)
    up = (b - a) / length
    side = np.cross(up, (1.0, 0.0, 0.0) if abs(up[0]) < 0.9 else (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    turn = np.column_stack([side, up, np.cross(side, up)])
    return shapes.Solid(solid.positions @ turn.T + a, solid.triangles)


def mannequin() -> Scene:
    """An artist's mannequin of over 50 000 vertices on a floor: near and far occluders, a head and a hand."""
    nodes = [shapes.floor(12.0, FLOOR)]
    for name, start, end, start_radius, end_radius in LIMBS:
        nodes.append(Node(shapes.mesh(limb(start, end, start_radius, end_radius), WOOD, name=name), name=name))
    light = rect_light((-1.6, 3.4, 2.4), (0.2, 0.6, -0.2), 0.5, 0.5)
    camera = Camera((2.3, 2.1, 3.6), (0.35, 0.6, -0.35), 40.0)
    return shapes.scene(nodes, light, camera, "mannequin")
