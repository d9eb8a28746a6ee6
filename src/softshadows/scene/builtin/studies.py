"""Small scenes that each ask one question: the papers' test objects, one rectangle, thin bars, many spheres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.builtin import shapes
from softshadows.scene.camera import Camera
from softshadows.scene.framing import rect_light
from softshadows.scene.lights import Light, RectLight
from softshadows.scene.model import Material, Mesh, Node, Scene

PAPER = Material("paper", (0.72, 0.70, 0.66, 1.0), roughness=0.95)
CARD = Material("card", (0.45, 0.47, 0.50, 1.0), roughness=0.9, double_sided=True)
BLUE = Material("blue", (0.10, 0.24, 0.50, 1.0), roughness=0.5)
RED = Material("red", (0.56, 0.10, 0.08, 1.0), roughness=0.45)
YELLOW = Material("yellow", (0.80, 0.52, 0.10, 1.0), roughness=0.5)
GREEN = Material("green", (0.16, 0.40, 0.18, 1.0), roughness=0.5)
WHITE = Material("white", (0.82, 0.82, 0.80, 1.0), roughness=0.6)
STEEL = Material("steel", (0.32, 0.34, 0.36, 1.0), roughness=0.4)


def blocker(
    *,
    light_height: float = 10.0,
    height: float = 4.0,
    light_half: tuple[float, float] = (1.0, 1.0),
    occluders: Sequence[tuple[float, float, float, float]] = ((-1.5, 1.5, -1.0, 1.0),),
    turn: float = 0.0,
    floor_half: float = 12.0,
    light: Light | None = None,
) -> Scene:
    """One rectangle over a floor, under a parallel rectangle light: the penumbra has a closed form.

    The floor is y = 0; the light lies at y = `light_height` around the y axis, with half extents `light_half` along x
    and z. Each occluder (x low, x high, z low, z high) is a card without thickness at y = `height`, turned about y by
    `turn` degrees; a far-away side makes it a half-plane. `light` replaces the rectangle. All lengths in metres.
    """
    if not 0.0 < height < light_height:
        raise SceneError(
            f"blocker: height must lie between 0 and the light's {light_height:g} m, got {height:g}", pointer="height"
        )
    nodes = [shapes.floor(floor_half, PAPER)]
    for x0, x1, z0, z1 in occluders:
        corners = np.array([(x0, 0, z0), (x0, 0, z1), (x1, 0, z1), (x1, 0, z0)], np.float32)
        card = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), material=CARD, name="blocker")
        nodes.append(Node(card, shapes.transform((0.0, height, 0.0), turn=turn), name="blocker"))
    if light is None:
        a, b = light_half
        light = rect_light((0.0, light_height, 0.0), (0.0, 0.0, 0.0), 2.0 * a, 2.0 * b)
    camera = Camera((5.0, 7.5, 10.5), (0.2, 0.6, 0.0), 42.0)
    return shapes.scene(nodes, light, camera, "blocker")


def sphere_cube(count: int = 3) -> Scene:
    """A cube of count³ spheres of 762 triangles, after Forest et al. 2006: many overlapping penumbrae."""
    if count < 1:
        raise SceneError(f"sphere_cube: count must be at least 1, got {count}", pointer="count")
    spacing, radius = 0.5, 0.18
    side = spacing * count
    ball = shapes.mesh(shapes.sphere(762, radius), RED, name="sphere")
    at = (np.arange(count) + 0.5) * spacing - side / 2.0
    nodes = [shapes.floor(8.0 * side, PAPER)]
    nodes += [
        Node(ball, shapes.transform((x, y + side / 2.0 + 0.15, z)), name="sphere") for y in at for z in at for x in at
    ]
    light = rect_light((0.5 * side, 2.9 * side, 0.3 * side), (0.0, 0.3 * side, 0.0), 0.7 * side, 0.7 * side)
    camera = Camera((1.6 * side, 1.9 * side, 2.2 * side), (-0.12 * side, 0.32 * side, -0.06 * side), 40.0)
    return shapes.scene(nodes, light, camera, "sphere_cube")


def figures() -> Scene:
    """Geometric figures after Reimann and Dreier 2016: small, pierced and round things, sharp and smooth edges."""
    grid = np.linspace(-0.45, 0.45, 8)
    holes = np.ones((7, 7), bool)
    holes[1::2, 1::2] = False
    sieve = shapes.place(shapes.panel(grid, grid + 0.5, holes, (-0.02, 0.02)), turn=35.0)
    cone = shapes.lathe([(0.34, 0.0), (0.0, 0.85)], 64)
    cylinder = shapes.lathe([(0.22, 0.0), (0.22, 0.95)], 64)
    cube = shapes.box((-0.25, -0.25, -0.25), (0.25, 0.25, 0.25))
    slab = shapes.box((-0.75, -0.03, -0.3), (0.75, 0.03, 0.3))
    nodes = [
        shapes.floor(20.0, PAPER),
        shapes.node(shapes.sphere(3048, 0.48), RED, (-0.25, 0.85, -0.55), name="big sphere"),
        shapes.node(slab, BLUE, (0.55, 1.35, -0.5), turn=12.0, name="flat cuboid, parallel to the floor"),
        shapes.node(shapes.place(slab, tilt=32.0), GREEN, (1.75, 0.55, 0.35), turn=-28.0, name="flat cuboid, slanted"),
        shapes.node(shapes.torus(0.34, 0.10, 64, 24), YELLOW, (-1.55, 0.62, 0.2), name="lying ring"),
        shapes.node(sieve, STEEL, (-1.35, 0.05, -1.25), name="plate with nine holes"),
        shapes.node(cone, WHITE, (0.35, 0.0, 0.75), name="cone"),
        shapes.node(cylinder, GREEN, (-0.75, 0.0, 0.95), name="cylinder"),
        shapes.node(cube, YELLOW, (1.15, 0.25, 1.15), turn=28.0, name="cube"),
        shapes.node(
            shapes.rounded_box((0.26, 0.26, 0.26), 0.11), BLUE, (-0.1, 0.27, 1.55), turn=-20.0, name="smooth cube"
        ),
    ]
    pebble = shapes.mesh(shapes.sphere(320, 0.05), STEEL, name="small sphere")
    die = shapes.mesh(shapes.rounded_box((0.045, 0.045, 0.045), 0.012, 3), RED, name="small cube")
    for k in range(6):
        nodes.append(
            Node(pebble, shapes.transform((0.75 + 0.17 * k, 0.05 + 0.06 * k, 1.85 - 0.05 * k)), name="small sphere")
        )
        nodes.append(
            Node(die, shapes.transform((-1.75 + 0.17 * k, 0.05 + 0.05 * k, 1.55), turn=17.0 * k), name="small cube")
        )
    needle = shapes.tube((-2.2, 0.0, 0.75), (-1.95, 1.1, 0.45), 0.012)
    nodes.append(shapes.node(needle, STEEL, name="slanted needle"))
    light = RectLight((1.6, 3.6, 1.4), (0.0, 0.3, 0.2), 0.9, 0.9, (78.0, 76.0, 72.0))
    camera = Camera((1.5, 3.3, 5.3), (0.12, 0.35, 0.2), 40.0)
    return shapes.scene(nodes, light, camera, "figures")


def fence(bars: int = 24, bar_width: float = 0.02) -> Scene:
    """A fence of thin bars, square, round and slanted: occluders narrower than the light, with little or no umbra."""
    if bars < 2 or not 0.0 < bar_width < 0.1:
        raise SceneError(
            f"fence: needs bars >= 2 and 0 < bar_width < 0.1 m, got {bars} and {bar_width:g}", pointer="bars"
        )
    spacing, height, half = 0.12, 1.3, bar_width / 2.0
    xs = (np.arange(bars) - (bars - 1) / 2.0) * spacing
    reach = xs[-1] + spacing / 2.0
    square = shapes.mesh(shapes.box((-half, 0.0, -half), (half, height, half)), STEEL, name="square bar")
    spike = [(half, 0.0), (half, height), (1.8 * half, height), (1.8 * half, height + 0.02), (0.0, height + 0.14)]
    round_bar = shapes.mesh(shapes.lathe(spike, 16), STEEL, name="round bar")
    nodes = [shapes.floor(20.0, PAPER)]
    nodes += [
        Node(round_bar if k % 2 else square, shapes.transform((x, 0.0, 0.0)), name="bar") for k, x in enumerate(xs)
    ]
    for y in (0.18, height - 0.18):
        nodes.append(shapes.node(shapes.box((-reach, y, -0.015), (reach, y + 0.04, 0.015)), STEEL, name="rail"))
    brace = shapes.tube((-reach, 0.2, -0.03), (reach, height - 0.16, -0.03), half)
    nodes.append(shapes.node(brace, STEEL, name="slanted brace"))
    post = shapes.rounded_box((0.06, 0.80, 0.06), 0.01, 2)
    nodes += [shapes.node(post, WHITE, (side * (reach + 0.06), 0.80, 0.0), name="post") for side in (-1, 1)]
    nodes.append(shapes.node(shapes.sphere(762, 0.22), YELLOW, (0.3, 0.22, 0.75), name="ball"))
    light = rect_light((-1.8, 3.8, -4.2), (0.0, 0.2, 0.4), 0.5, 0.5, irradiance=7.0)
    camera = Camera((1.7, 1.9, 3.6), (-0.05, 0.42, 0.3), 42.0)
    return shapes.scene(nodes, light, camera, "fence")


def field(count: int = 1000) -> Scene:
    """Spheres scattered over a floor, about `count` triangles in all (10³ to 10⁶): cost against scene size."""
    if not 500 <= count <= 4_000_000:
        raise SceneError(f"field: count must lie in [500, 4000000] triangles, got {count}", pointer="count")
    each = 2 * round(float(np.clip(np.sqrt(count), 80.0, 762.0)) / 2.0)
    spheres = max(1, round(count / each))
    ball = shapes.sphere(each)
    palette = [
        shapes.mesh(ball, material, crease=180.0, name="sphere") for material in (RED, BLUE, YELLOW, GREEN, WHITE)
    ]
    rng = np.random.default_rng(2012)
    columns = int(np.ceil(np.sqrt(spheres)))
    cell = 6.0 / columns
    nodes = [shapes.floor(20.0, PAPER)]
    for k in range(spheres):
        radius = cell * rng.uniform(0.16, 0.42)
        x, z = (np.array([k % columns, k // columns]) + 0.5 + rng.uniform(-0.25, 0.25, 2)) * cell - 3.0
        y = radius + max(0.0, rng.uniform(-0.6, 0.8))
        nodes.append(Node(palette[rng.integers(5)], shapes.transform((x, y, z), scale=radius), name="sphere"))
    light = rect_light((2.0, 6.5, 1.0), (0.0, 0.0, 0.0), 1.6, 1.6)
    camera = Camera((4.2, 4.3, 6.0), (0.0, 0.1, 0.2), 42.0)
    return shapes.scene(nodes, light, camera, "field")
