"""A furnished room with real walls: light and camera are inside, everything outside is dark."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from softshadows.scene.builtin import shapes
from softshadows.scene.builtin.shapes import Solid
from softshadows.scene.camera import Camera
from softshadows.scene.lights import RectLight
from softshadows.scene.model import Material, Node, Scene

PLASTER = Material("plaster", (0.78, 0.75, 0.70, 1.0), roughness=0.95)
PARTITION = Material("partition", (0.55, 0.62, 0.60, 1.0), roughness=0.95)
PLANKS = [
    Material(f"plank {k}", (0.42 + t, 0.27 + t, 0.15 + t, 1.0), roughness=0.6) for k, t in enumerate((0.0, 0.04, -0.04))
]
OAK = Material("oak", (0.50, 0.32, 0.16, 1.0), roughness=0.6)
DARK = Material("dark wood", (0.16, 0.10, 0.07, 1.0), roughness=0.5)
CLOTH = Material("cloth", (0.16, 0.26, 0.40, 1.0), roughness=0.95)
CERAMIC = Material("ceramic", (0.82, 0.80, 0.76, 1.0), roughness=0.3)
BOOKS = [
    Material(f"book {k}", (*color, 1.0), roughness=0.8)
    for k, color in enumerate([(0.45, 0.10, 0.08), (0.10, 0.22, 0.35), (0.62, 0.52, 0.30), (0.12, 0.28, 0.16)])
]
FRUIT = [
    Material("apple", (0.58, 0.09, 0.05, 1.0), roughness=0.35),
    Material("orange", (0.85, 0.40, 0.05, 1.0), roughness=0.5),
]

HALF_X, HALF_Z, HEIGHT = 2.6, 2.0, 2.6
WALL = 0.05
PARTITION_X, PARTITION_THICKNESS = 1.25, 0.03


def room() -> Scene:
    """A closed, furnished room of thin walls with the light and the camera inside: nothing may leak.

    Inside 5.2 × 4 × 2.6 m, walls 5 cm; a partition of 3 cm with a doorway keeps most of the light from the far end.
    """
    nodes = [
        shapes.node(_shell(), PLASTER, name="walls, floor and ceiling"),
        shapes.node(_partition(), PARTITION, (PARTITION_X, 0.0, 0.0), turn=90.0, name="partition"),
        *_planks(),
        *_table(),
        *_shelf(),
        *_sofa(),
    ]
    chair = shapes.mesh(_chair(), OAK, name="chair")
    for x, z, turn in ((-0.95, -1.02, 4.0), (-0.05, -1.05, -8.0), (-0.40, 0.42, 200.0)):
        nodes.append(Node(chair, shapes.transform((x, 0.015, z), turn=turn), name="chair"))
    picture = shapes.panel(
        [-0.5, -0.44, 0.44, 0.5], [1.2, 1.26, 1.84, 1.9], [[1, 1, 1], [1, 0, 1], [1, 1, 1]], (0.0, 0.04)
    )
    nodes.append(shapes.node(picture, DARK, (-0.45, 0.0, -HALF_Z), name="picture frame"))
    stool = shapes.lathe([(0.17, 0.0), (0.17, 0.02), (0.03, 0.05), (0.03, 0.40), (0.19, 0.42), (0.19, 0.45)], 40)
    nodes.append(shapes.node(stool, DARK, (2.0, 0.015, 0.35), name="stool beyond the doorway"))
    light = RectLight((-0.7, HEIGHT - 0.08, 0.05), (-0.7, 0.0, 0.05), 0.9, 0.9, (26.0, 24.5, 22.0))
    camera = Camera((-2.35, 1.62, 1.75), (0.55, 0.78, -0.55), 66.0)
    return shapes.scene(nodes, light, camera, "room")


def _shell() -> Solid:
    """One closed solid with a cavity: the outer box, and the inner box seen from inside."""
    outside = shapes.box((-HALF_X - WALL, -WALL, -HALF_Z - WALL), (HALF_X + WALL, HEIGHT + WALL, HALF_Z + WALL))
    inside = shapes.box((-HALF_X, 0.0, -HALF_Z), (HALF_X, HEIGHT, HALF_Z))
    return shapes.join(outside, Solid(inside.positions, inside.triangles[:, ::-1]))


def _partition() -> Solid:
    """A plate with a doorway; its rim reaches 2 cm into the walls so that no light passes around it."""
    into = 0.02
    half = PARTITION_THICKNESS / 2.0
    along = [-HALF_Z - into, -1.15, -0.25, HALF_Z + into]
    return shapes.panel(along, [-into, 2.05, HEIGHT + into], [[1, 0, 1], [1, 1, 1]], (-half, half))


def _planks() -> list[Node]:
    rng = np.random.default_rng(3)
    edges = np.linspace(-HALF_Z, HALF_Z, 21)
    boards: list[list[Solid]] = [[], [], []]
    for near, far in pairwise(edges):
        cuts = [-HALF_X, *np.sort(rng.uniform(-HALF_X + 0.4, HALF_X - 0.4, 2)), HALF_X]
        for start, end in pairwise(cuts):
            boards[rng.integers(3)].append(shapes.box((start, 0.0, near), (end, 0.015, far)))
    return [
        shapes.node(shapes.join(*group), plank, name="floor boards")
        for group, plank in zip(boards, PLANKS, strict=True)
    ]


def _table() -> list[Node]:
    top = shapes.place(shapes.rounded_box((0.80, 0.018, 0.45), 0.012, 3), (0.0, 0.74, 0.0))
    legs = [
        shapes.place(shapes.lathe([(0.018, 0.0), (0.034, 0.724)], 20), (x, 0.0, z))
        for x in (-0.72, 0.72)
        for z in (-0.37, 0.37)
    ]
    apron = shapes.panel(
        [-0.7, -0.68, 0.68, 0.7],
        [-0.35, -0.33, 0.33, 0.35],
        [[1, 1, 1], [1, 0, 1], [1, 1, 1]],
        (0.65, 0.72),
        lying=True,
    )
    bowl = shapes.lathe(
        [(0.06, 0.0), (0.06, 0.012), (0.12, 0.04), (0.165, 0.085), (0.158, 0.086), (0.11, 0.048), (0.0, 0.02)], 48
    )
    at = np.array([-0.45, 0.015, -0.35])
    table = shapes.join(top, apron, *legs)
    nodes = [
        shapes.node(table, OAK, at, name="table"),
        shapes.node(bowl, CERAMIC, at + np.array((0.1, 0.758, 0.02)), name="bowl"),
    ]
    fruit = [shapes.mesh(shapes.sphere(320, 0.042), material, name=material.name) for material in FRUIT]
    for k, (x, y, z) in enumerate(
        [(-0.05, 0.076, 0.03), (0.045, 0.076, 0.04), (0.0, 0.076, -0.05), (0.0, 0.138, 0.01)]
    ):
        nodes.append(Node(fruit[k % 2], shapes.transform(at + np.array((0.1 + x, 0.758 + y, 0.02 + z))), name="fruit"))
    cup_profile = [(0.025, 0.0), (0.038, 0.03), (0.04, 0.085), (0.036, 0.085), (0.034, 0.03), (0.0, 0.012)]
    cup = shapes.mesh(shapes.lathe(cup_profile, 32), CERAMIC, name="cup")
    for x, z in ((-0.45, -0.18), (0.48, 0.16)):
        nodes.append(Node(cup, shapes.transform(at + np.array((x, 0.758, z))), name="cup"))
    return nodes


def _chair() -> Solid:
    """Faces +z; its back is towards −z."""
    seat = shapes.place(shapes.rounded_box((0.22, 0.016, 0.21), 0.012, 2), (0.0, 0.45, 0.0))
    front = [shapes.tube((x, 0.0, 0.17), (0.9 * x, 0.44, 0.16), 0.015) for x in (-0.19, 0.19)]
    back = [shapes.tube((x, 0.0, -0.2), (0.95 * x, 0.92, -0.27), 0.015) for x in (-0.19, 0.19)]
    slats = [shapes.tube((x, 0.46, -0.235), (x, 0.86, -0.265), 0.008, 8) for x in np.linspace(-0.13, 0.13, 5)]
    top = shapes.place(shapes.rounded_box((0.20, 0.035, 0.012), 0.01, 2), (0.0, 0.88, -0.267))
    stretchers = [shapes.tube((x, 0.2, 0.165), (x, 0.2, -0.215), 0.010, 8) for x in (-0.18, 0.18)]
    return shapes.join(seat, *front, *back, *slats, top, *stretchers)


def _shelf() -> list[Node]:
    """A bookcase against the partition, its open side towards the light."""
    width, height, depth, board = 1.1, 1.8, 0.26, 0.02
    ys = np.array([0.0, 0.08, 0.10, 0.42, 0.44, 0.78, 0.80, 1.10, 1.12, 1.44, 1.46, height - board, height])
    filled = np.ones((len(ys) - 1, 3), bool)
    filled[2:-1:2, 1] = False  # the compartments between the boards
    case = shapes.panel([-width / 2, -width / 2 + board, width / 2 - board, width / 2], ys, filled, (0.0, depth))
    back = shapes.box((-width / 2, 0.0, -0.012), (width / 2, height, 0.0))
    place = {"move": (PARTITION_X - PARTITION_THICKNESS / 2 - 0.02, 0.015, -1.15), "turn": -90.0}
    nodes = [shapes.node(shapes.join(case, back), DARK, **place, name="bookcase")]
    rng = np.random.default_rng(11)
    volumes: list[list[Solid]] = [[] for _ in BOOKS]
    for low, high in zip(ys[2:-1:2], ys[3::2], strict=True):
        x = -width / 2 + board + 0.01
        while x < width / 2 - 0.10 and not (x > 0.1 and rng.random() < 0.10):
            thickness, tall, deep = (
                rng.uniform(0.02, 0.05),
                rng.uniform(0.65, 0.93) * (high - low),
                rng.uniform(0.15, 0.21),
            )
            volumes[rng.integers(len(BOOKS))].append(shapes.box((x, low, 0.01), (x + thickness, low + tall, deep)))
            x += thickness + 0.002
    for group, cover in zip(volumes, BOOKS, strict=True):
        nodes.append(shapes.node(shapes.join(*group), cover, **place, name="books"))
    return nodes


def _sofa() -> list[Node]:
    """Against the wall at −x: two seats, arms, a pillow."""
    seat = shapes.place(shapes.rounded_box((0.42, 0.11, 0.38), 0.05), (0.0, 0.32, 0.0))
    base = shapes.place(shapes.rounded_box((0.95, 0.10, 0.40), 0.02, 2), (0.0, 0.14, 0.0))
    arm = shapes.rounded_box((0.09, 0.27, 0.40), 0.05)
    back = shapes.place(shapes.rounded_box((0.95, 0.36, 0.10), 0.06), (0.0, 0.42, -0.40))
    pillow = shapes.place(shapes.rounded_box((0.20, 0.19, 0.06), 0.058), (-0.62, 0.62, -0.22), turn=14.0)
    body = shapes.join(
        base,
        back,
        shapes.place(seat, (-0.42, 0.0, 0.02)),
        shapes.place(seat, (0.42, 0.0, 0.02)),
        shapes.place(arm, (-0.97, 0.29, 0.0)),
        shapes.place(arm, (0.97, 0.29, 0.0)),
    )
    at = {"move": (-1.95, 0.015, -0.55), "turn": 90.0}
    return [shapes.node(body, CLOTH, **at, name="sofa"), shapes.node(pillow, BOOKS[2], **at, name="pillow")]
