"""An arcaded courtyard of two storeys: columns, arches, groin vaults, drapes and a fountain, open to the sky.

The plan is a court of 7 × 3 bays inside a gallery; everything repeats by bay, so parts are made once (atrium_parts.py)
and placed by nodes. A side's own frame has x along the arcade and z outward, from the court into the gallery.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from softshadows.scene.builtin import atrium_parts as parts
from softshadows.scene.builtin import shapes
from softshadows.scene.builtin.atrium_parts import BAY, GALLERY, LOWER, UPPER, WALL_THICKNESS
from softshadows.scene.camera import Camera
from softshadows.scene.framing import rect_light
from softshadows.scene.model import Material, Mesh, Node, Scene, Texture

BAYS_X, BAYS_Z = 7, 3
HALF_X, HALF_Z = BAYS_X * BAY / 2.0, BAYS_Z * BAY / 2.0  # of the court, between the lines of columns
STEPS, STEP_HEIGHT, STEP_DEPTH = 3, 0.15, 0.36
COURT = -STEPS * STEP_HEIGHT  # the court's floor lies three steps below the gallery's

STONE = Material("stone", (0.62, 0.55, 0.44, 1.0), roughness=0.85)
MARBLE = Material("marble", (0.74, 0.70, 0.63, 1.0), roughness=0.5)
VAULT = Material("vault", (0.66, 0.58, 0.47, 1.0), roughness=0.95)
DOOR = Material("door", (0.20, 0.11, 0.06, 1.0), roughness=0.6)
BRONZE = Material("bronze", (0.30, 0.20, 0.10, 1.0), metallic=0.6, roughness=0.45)
FABRICS = [
    Material("crimson drape", (0.42, 0.035, 0.03, 1.0), roughness=0.95),
    Material("green drape", (0.05, 0.20, 0.10, 1.0), roughness=0.95),
    Material("blue drape", (0.04, 0.10, 0.28, 1.0), roughness=0.95),
]


def atrium() -> Scene:
    """A two-storey arcaded courtyard with vaults, drapes and a fountain, over 100,000 triangles."""
    nodes = [*_ground(), *_walls(), *_columns(), *_arcades(), *_vaults(), *_mouldings(), *_drapes(), *_fountain()]
    light = rect_light((-5.2, 11.2, 1.0), (1.5, 1.0, -4.2), 3.0, 3.0, irradiance=5.5)
    camera = Camera((-8.3, 1.75, 2.2), (3.0, 2.6, -1.6), 62.0)
    return shapes.scene(nodes, light, camera, "atrium")


@cache
def _ashlar() -> Material:
    """Dressed stone in courses; its picture is made on first use, not on import."""
    texture = Texture(parts.ashlar_texture())
    return Material("ashlar", base_color_texture=texture, base_color=(1.0, 1.0, 1.0, 1.0), roughness=0.9)


@cache
def _paving() -> Material:
    texture = Texture(parts.paving_texture())
    return Material("paving", base_color_texture=texture, base_color=(1.0, 1.0, 1.0, 1.0), roughness=0.6)


def _sides() -> list[tuple[float, int, float]]:
    """(turn about y in degrees, number of bays, distance from the centre to the line of columns) of the four sides."""
    return [(0.0, BAYS_X, HALF_Z), (180.0, BAYS_X, HALF_Z), (90.0, BAYS_Z, HALF_X), (-90.0, BAYS_Z, HALF_X)]


def _along(mesh: Mesh, *, at_columns: bool = False, y: float = 0.0, outward: float = 0.0) -> list[Node]:
    """`mesh` once per bay of all four sides, or once per column between two bays, `outward` metres behind."""
    nodes = []
    for turn, bays, distance in _sides():
        places = np.arange(1, bays) - bays / 2.0 if at_columns else np.arange(bays) + 0.5 - bays / 2.0
        turned = shapes.transform(turn=turn)
        nodes += [
            Node(mesh, turned @ shapes.transform((x * BAY, y, distance + outward)), name=mesh.name) for x in places
        ]
    return nodes


def _at_corners(mesh: Mesh, *, y: float = 0.0, beyond: float = 0.0) -> list[Node]:
    corners = [(sx * (HALF_X + beyond), sz * (HALF_Z + beyond)) for sx in (-1, 1) for sz in (-1, 1)]
    return [Node(mesh, shapes.transform((x, y, z)), name=mesh.name) for x, z in corners]


def _ring(inset: float, outset: float, height: tuple[float, float]) -> shapes.Solid:
    """A frame around the court, from `inset` metres before the line of columns to `outset` behind it."""
    return shapes.frame((HALF_X - inset, HALF_Z - inset), (HALF_X + outset, HALF_Z + outset), height)


def _ground() -> list[Node]:
    x, z = HALF_X - 0.3, HALF_Z - 0.3
    court = shapes.box((-x, COURT - 0.2, -z), (x, COURT, z))
    gallery = _ring(0.45, GALLERY, (COURT - 0.2, 0.0))
    treads = [_ring(0.45 + STEP_DEPTH * step, -0.3, (COURT - 0.1, -STEP_HEIGHT * step)) for step in range(1, STEPS)]
    return [
        Node(shapes.mesh(court, _paving(), tile=2.0, name="court floor"), name="court floor"),
        Node(shapes.mesh(gallery, _paving(), tile=2.0, name="gallery floor"), name="gallery floor"),
        *(shapes.node(tread, MARBLE, name="step") for tread in treads),
    ]


def _walls() -> list[Node]:
    """The outer wall with its doors and windows, the upper floor, the roof over the galleries."""
    behind = GALLERY
    shell = _ring(-behind, behind + 0.4, (COURT - 0.2, UPPER.top + 0.1))
    upper_floor = _ring(0.30, behind + 0.1, (LOWER.top, UPPER.base))
    roof = _ring(0.30, behind + 0.4, (UPPER.top, UPPER.top + 0.25))
    door = shapes.mesh(parts.door(), DOOR, name="door")
    facing = shapes.mesh(parts.wall_bay(), _ashlar(), tile=2.0, name="wall")
    pilaster = shapes.mesh(parts.pilaster(LOWER), STONE, name="pilaster")
    return [
        Node(shapes.mesh(shell, _ashlar(), tile=2.0, name="outer wall"), name="outer wall"),
        Node(shapes.mesh(upper_floor, _paving(), tile=2.0, name="upper floor"), name="upper floor"),
        shapes.node(roof, STONE, name="roof"),
        *_along(facing, outward=behind),
        *_along(door, outward=behind),
        *_along(pilaster, at_columns=True, outward=behind - 0.15),
    ]


def _columns() -> list[Node]:
    fluted = shapes.mesh(parts.column_shaft(LOWER, fluted=True), MARBLE, name="fluted shaft")
    foot = shapes.mesh(parts.column_foot(LOWER), STONE, name="column base")
    head = shapes.mesh(parts.column_capital(LOWER), STONE, crease=50.0, name="capital")
    plain = shapes.mesh(parts.column_shaft(UPPER, fluted=False), MARBLE, name="plain shaft")
    upper_foot = shapes.mesh(parts.column_foot(UPPER), STONE, name="upper base")
    upper_head = shapes.mesh(parts.plain_capital(UPPER), STONE, name="upper capital")
    nodes = []
    for part in (fluted, foot, head, plain, upper_foot, upper_head):
        nodes += _along(part, at_columns=True)
    for storey in (LOWER, UPPER):
        nodes += _at_corners(shapes.mesh(parts.pier(storey), STONE, name="corner pier"))
    return nodes


def _arcades() -> list[Node]:
    nodes = []
    for storey in (LOWER, UPPER):
        nodes += _along(shapes.mesh(parts.arch_bay(storey), _ashlar(), tile=2.0, name="arch"))
        nodes += _along(shapes.mesh(parts.archivolt(storey), STONE, name="archivolt"))
    nodes += _along(
        shapes.mesh(parts.roundel(), MARBLE, name="roundel"),
        at_columns=True,
        y=LOWER.springing + 0.95,
        outward=-WALL_THICKNESS / 2,
    )
    nodes += _along(shapes.mesh(parts.balustrade(), MARBLE, name="balustrade"), y=UPPER.base)
    return nodes


def _vaults() -> list[Node]:
    """A groin vault over every bay of the lower gallery and its four corners, with a transverse rib between them."""
    depth = GALLERY - WALL_THICKNESS / 2.0
    middle = WALL_THICKNESS / 2.0 + depth / 2.0
    bay = shapes.mesh(parts.groin_vault(BAY, depth), VAULT, name="vault")
    corner = shapes.mesh(parts.groin_vault(depth, depth), VAULT, name="corner vault")
    rib = shapes.mesh(parts.rib(depth), STONE, name="rib")
    return [
        *_along(bay, outward=middle),
        *_along(rib, at_columns=True, outward=middle),
        *_at_corners(corner, beyond=middle),
    ]


def _mouldings() -> list[Node]:
    """Stepped cornices above both storeys, with a row of dentils under each."""
    nodes = []
    for storey in (LOWER, UPPER):
        for low, high, inset in ((-0.26, -0.20, 0.30), (-0.10, -0.04, 0.37), (-0.04, 0.10, 0.44), (0.10, 0.18, 0.50)):
            nodes.append(shapes.node(_ring(inset, 0.2, (storey.top + low, storey.top + high)), STONE, name="cornice"))
        dentils = parts.dentils(storey.top - 0.20, storey.top - 0.10)
        nodes += _along(shapes.mesh(dentils, STONE, name="dentils"))
    return nodes


def _drapes() -> list[Node]:
    """Curtains tied back to the columns of every other bay below, banners over the balustrade above."""
    halves = [shapes.mesh(parts.curtain(side), FABRICS[0], crease=80.0, name="curtain") for side in (-1, 1)]
    rod = shapes.mesh(
        shapes.tube((-1.0, LOWER.springing - 0.28, 0.0), (1.0, LOWER.springing - 0.28, 0.0), 0.02), BRONZE, name="rod"
    )
    banner = [shapes.mesh(parts.banner(), fabric, crease=80.0, name="banner") for fabric in FABRICS]
    nodes = []
    for turn, bays, distance in _sides()[:2]:
        turned = shapes.transform(turn=turn)
        for bay in range(bays):
            place = turned @ shapes.transform(((bay + 0.5 - bays / 2.0) * BAY, 0.0, distance + 0.05))
            if bay % 3 == 2:
                nodes += [Node(part, place, name=part.name) for part in (*halves, rod)]
            if bay % 2 == 1:
                nodes.append(Node(banner[(bay // 2) % 3], place, name="banner"))
    return nodes


def _fountain() -> list[Node]:
    base = [(1.30, COURT), (1.30, COURT + 0.15), (1.05, COURT + 0.15), (1.05, COURT + 0.30)]
    nodes = [shapes.node(shapes.lathe(base, 8), MARBLE, turn=22.5, name="fountain steps")]
    for profile, material in zip(parts.fountain_profiles(), (STONE, MARBLE, BRONZE), strict=True):
        nodes.append(shapes.node(shapes.lathe(profile, 56), material, (0.0, COURT + 0.30, 0.0), name="fountain"))
    return nodes
