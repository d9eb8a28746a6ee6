"""The parts of the atrium: columns, arches, vaults, balusters, cloth, and the pictures of its stone.

Each function makes one closed solid (or several joined), in the frame of a bay: x along the arcade, y up from the
gallery's floor, z outward into the gallery.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows.scene.builtin import shapes
from softshadows.scene.builtin.shapes import Solid

BAY = 2.6
GALLERY = 3.0  # from the line of columns to the outer wall
WALL_THICKNESS = 0.5


@dataclass(frozen=True)
class Storey:
    """Heights above the gallery's floor, and the radius of the columns at their foot: metres."""

    base: float
    springing: float  # where arches start, the top of the capitals
    top: float  # of the wall above the arches
    radius: float


LOWER = Storey(base=0.0, springing=3.0, top=4.75, radius=0.27)
UPPER = Storey(base=4.95, springing=7.45, top=9.05, radius=0.19)


def _curve(points: npt.ArrayLike, steps: int) -> npt.NDArray[np.float64]:
    """A smooth curve through `points`, (n, 2): cubic between them (Catmull and Rom), `steps` pieces each."""
    p = np.asarray(points, np.float64)
    p = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    t = (np.arange(steps) / steps)[:, None]
    pieces = [
        b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
        for a, b, c, d in zip(p[:-3], p[1:-2], p[2:-1], p[3:], strict=True)
    ]
    return np.vstack([*pieces, p[-2]])


def _torus_profile(radius: float, bulge: float, low: float, high: float, steps: int = 5) -> list[tuple[float, float]]:
    """Half-round moulding of a column: from (radius, low) out by `bulge` and back to (radius, high)."""
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, steps + 1)
    return [(radius + bulge * np.cos(a), (low + high) / 2.0 + (high - low) / 2.0 * np.sin(a)) for a in angle]


def column_foot(storey: Storey) -> Solid:
    """A square plinth and an Attic base: a torus, a hollow, a smaller torus."""
    r, y = storey.radius, storey.base
    scale = r / 0.27
    plinth = shapes.box((-1.4 * r, y, -1.4 * r), (1.4 * r, y + 0.12 * scale, 1.4 * r))
    hollow = _curve([(1.16 * r, 0.22), (1.05 * r, 0.245), (1.08 * r, 0.275)], 3)
    profile = [*_torus_profile(1.2 * r, 0.16 * r, 0.12, 0.21), *hollow, *_torus_profile(1.06 * r, 0.10 * r, 0.28, 0.34)]
    rings = [(radius, y + height * scale) for radius, height in profile]
    return shapes.join(plinth, shapes.lathe(rings, 28 if storey is LOWER else 16))


def column_shaft(storey: Storey, *, fluted: bool) -> Solid:
    """A tapering shaft with a slight swelling; twenty flutes, or plain."""
    scale = storey.radius / 0.27
    low, high = storey.base + 0.33 * scale, storey.springing - 0.50 * scale
    t = np.array([0.0, 0.02, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 0.98, 1.0])
    radius = storey.radius * (1.0 - 0.15 * t**1.8)
    profile = np.column_stack([radius, low + t * (high - low)])
    if not fluted:
        return shapes.lathe(profile, 20)
    across = np.tile([0.0, 0.85, 1.0, 0.85], 20)  # four facets per flute, sharp ridges between flutes
    depth = np.array([0.0, 0.0, 0.055, 0.06, 0.06, 0.06, 0.06, 0.055, 0.0, 0.0])
    return shapes.lathe(profile, 80, flutes=1.0 - depth[:, None] * across)


def column_capital(storey: Storey) -> Solid:
    """A bell with two tiers of eight curled leaves under a square abacus."""
    r, low, top = 0.85 * storey.radius, storey.springing - 0.50, storey.springing
    necking = _torus_profile(r, 0.15 * r, low, low + 0.05, 4)
    bell = _curve([(r, low + 0.06), (1.04 * r, low + 0.2), (1.25 * r, low + 0.32), (1.5 * r, low + 0.38)], 2)
    abacus = shapes.box((-0.36, top - 0.12, -0.36), (0.36, top, 0.36))
    leaves = []
    for tier, (height, curl) in enumerate(((0.19, 0.07), (0.31, 0.11))):
        leaf = _leaf(1.02 * r, low + 0.05, height, 0.15, curl)
        leaves += [shapes.place(leaf, turn=45.0 * k + 22.5 * tier) for k in range(8)]
    return shapes.join(shapes.lathe([*necking, *bell], 28), abacus, *leaves)


def _leaf(radius: float, low: float, height: float, width: float, curl: float) -> Solid:
    """A leaf standing at x = `radius`, 1.2 cm thick, curling outward and drooping at its tip."""
    t = np.linspace(0.0, 1.0, 6)[:, None]
    s = np.linspace(-0.5, 0.5, 3)
    out = radius + 0.02 + curl * t**3 - 0.06 * s**2
    up = low + height * (t - 0.28 * t**6) + 0.0 * s
    side = s * width * (1.0 - 0.55 * t**4)
    front = np.stack([out, up, side + 0.0 * out], axis=-1)
    return shapes.between(front, front - np.array((0.012, 0.0, 0.0)))


def plain_capital(storey: Storey) -> Solid:
    """A Tuscan capital: necking ring, quarter-round echinus, square abacus."""
    r, top = 0.85 * storey.radius, storey.springing
    profile = [
        *_torus_profile(r, 0.12 * r, top - 0.36, top - 0.32, 4),
        (r, top - 0.2),
        *_curve([(1.05 * r, top - 0.2), (1.35 * r, top - 0.14), (1.45 * r, top - 0.1)], 3),
    ]
    return shapes.join(shapes.lathe(profile, 20), shapes.box((-0.3, top - 0.1, -0.3), (0.3, top, 0.3)))


def pier(storey: Storey) -> Solid:
    """The square pier at a corner of the court, with a foot and a cap."""
    low, high, half = storey.base, storey.springing, 0.36
    boxes = [
        (low, low + 0.3, half + 0.06),
        (low, high + 0.9, half),
        (high - 0.26, high - 0.18, half + 0.04),
        (high - 0.12, high, half + 0.08),
    ]
    return shapes.join(*(shapes.box((-h, a, -h), (h, b, h)) for a, b, h in boxes))


def pilaster(storey: Storey) -> Solid:
    """A flat pillar against the outer wall, opposite a column."""
    low, high = storey.base, storey.springing
    boxes = [(low, low + 0.25, 0.30, 0.20), (low, high - 0.1, 0.24, 0.15), (high - 0.12, high, 0.30, 0.20)]
    return shapes.join(*(shapes.box((-half, a, -deep), (half, b, 0.15)) for a, b, half, deep in boxes))


def _arc(storey: Storey, radius: float, steps: int = 24) -> npt.NDArray[np.float64]:
    """(steps + 1, 2): a half circle from the left springing point to the right one."""
    angle = np.linspace(np.pi, 0.0, steps + 1)
    return np.column_stack([radius * np.cos(angle), storey.springing + radius * np.sin(angle)])


def _span(storey: Storey) -> float:
    """Radius of the storey's arches: half the bay less half an abacus."""
    return BAY / 2.0 - (0.32 if storey is LOWER else 0.27)


def arch_bay(storey: Storey) -> Solid:
    """One bay of wall above an arch, from column to column."""
    arc = _arc(storey, _span(storey))
    ends = np.array([[BAY / 2.0, storey.springing]])
    below = np.vstack([ends * np.array((-1, 1)), arc, ends])
    above = np.column_stack([below[:, 0], np.full(len(below), storey.top)])
    half = WALL_THICKNESS / 2.0
    return shapes.extrude(below, above, (-half, half))


def archivolt(storey: Storey) -> Solid:
    """The stepped moulding around an arch, and its keystone, standing proud of the wall on both faces."""
    radius, half = _span(storey), WALL_THICKNESS / 2.0
    bands = [(0.0, 0.10, 0.03), (0.10, 0.16, 0.06)]
    solids = [
        shapes.extrude(_arc(storey, radius + near), _arc(storey, radius + far), (-half - proud, half + proud))
        for near, far, proud in bands
    ]
    crown = storey.springing + radius
    key = (
        np.array([(-0.09, crown - 0.03), (0.09, crown - 0.03)]),
        np.array([(-0.13, crown + 0.24), (0.13, crown + 0.24)]),
    )
    return shapes.join(*solids, shapes.extrude(*key, (-half - 0.10, half + 0.10)))


def roundel() -> Solid:
    """A ring and a boss on the wall between two arches, facing the court."""
    ring = shapes.place(shapes.torus(0.24, 0.035, 28, 8), tilt=90.0, turn=90.0)
    boss = shapes.place(shapes.lathe(_curve([(0.12, -0.02), (0.09, 0.03), (0.0, 0.05)], 3), 24), tilt=90.0, turn=90.0)
    return shapes.join(ring, boss)


def balustrade() -> Solid:
    """A rail on turned balusters, from column to column of the upper storey."""
    turned = _curve([(0.055, 0.10), (0.035, 0.16), (0.075, 0.30), (0.040, 0.50), (0.032, 0.60), (0.055, 0.68)], 1)
    baluster = shapes.lathe(turned, 12)
    half = BAY / 2.0 - 0.2
    solids = [shapes.box((-half, 0.0, -0.09), (half, 0.10, 0.09)), shapes.box((-half, 0.68, -0.11), (half, 0.80, 0.11))]
    return shapes.join(*solids, *(shapes.place(baluster, (x, 0.0, 0.0)) for x in np.linspace(-0.96, 0.96, 8)))


def dentils(low: float, high: float) -> Solid:
    """Thirteen blocks under the cornice of a bay, on the court's side."""
    face = -WALL_THICKNESS / 2.0
    at = (np.arange(13) - 6.0) * BAY / 13.0
    return shapes.join(*(shapes.box((x - 0.05, low, face - 0.10), (x + 0.05, high, face + 0.02)) for x in at))


def groin_vault(width: float, depth: float, rise: float = 1.32, cells: int = 14) -> Solid:
    """The crossing of two barrel vaults over `width` × `depth`, flat above; its groins follow the grid's diagonals."""
    across = -np.cos(np.linspace(0.0, np.pi, cells + 1))  # dense where the vault rises steeply
    height = rise * np.sqrt(1.0 - np.minimum(across**2, 1.0))
    x, z = np.meshgrid(across * width / 2.0, across * depth / 2.0, indexing="ij")
    ceiling = LOWER.springing + np.maximum(height[:, None], height)
    top = np.full_like(ceiling, LOWER.top)
    return shapes.between(np.stack([x, ceiling, z], axis=-1), np.stack([x, top, z], axis=-1))


def rib(depth: float, rise: float = 1.32, width: float = 0.40) -> Solid:
    """The arch across the gallery under the seam of two vaults, a hand's breadth thick."""
    angle = np.linspace(np.pi, 0.0, 25)
    outer = np.column_stack([depth / 2.0 * np.cos(angle), LOWER.springing + (rise + 0.06) * np.sin(angle)])
    inner = np.column_stack([(depth / 2.0 - 0.10) * np.cos(angle), LOWER.springing + (rise - 0.06) * np.sin(angle)])
    return shapes.place(shapes.extrude(inner, outer, (-width / 2.0, width / 2.0)), turn=90.0)


def wall_bay() -> Solid:
    """The facing of the outer wall in one bay: a doorway below, a window above, both in front of the solid wall."""
    half, door, window = BAY / 2.0, 0.62, 0.48
    xs = [-half, -door, -window, window, door, half]
    ys = [-0.1, 2.35, UPPER.base + 1.0, UPPER.base + 2.5, UPPER.top]
    filled = [[1, 0, 0, 0, 1], [1, 1, 1, 1, 1], [1, 1, 0, 1, 1], [1, 1, 1, 1, 1]]
    return shapes.panel(xs, ys, filled, (-0.16, 0.05))


def door() -> Solid:
    """A double door with raised panels, set back in its doorway, under a small hood."""
    leaves = []
    for side in (-1, 1):
        leaves.append(shapes.box((side * 0.62, -0.05, -0.05), (side * 0.01, 2.4, 0.02)))
        for low, high in ((0.2, 0.85), (1.0, 1.55), (1.7, 2.15)):
            field = shapes.rounded_box((0.21, (high - low) / 2.0, 0.025), 0.02, 1)
            leaves.append(shapes.place(field, (side * 0.315, (low + high) / 2.0, -0.05)))
    return shapes.join(*leaves, shapes.box((-0.78, 2.42, -0.28), (0.78, 2.52, 0.0)))


def curtain(side: int) -> Solid:
    """Half of a curtain (`side` −1 left, 1 right) that falls from the rod and is tied to the column, 1.2 cm thick."""
    t = np.linspace(0.0, 1.0, 15)[:, None]
    s = np.linspace(0.0, 1.0, 37)
    tie = np.exp(-(((t - 0.62) / 0.22) ** 2))  # 1 where the cord gathers the cloth
    width = 0.95 * (1.0 - 0.35 * t) * (1.0 - 0.62 * tie)
    x = side * (0.96 - s * width)
    y = LOWER.springing - 0.28 - 2.55 * t - 0.16 * s * tie
    fold = 0.035 + 0.035 * tie
    z = fold * np.sin(2.0 * np.pi * 5.0 * s + 1.3 * t) + 0.02 * np.sin(9.0 * t + 2.0 * s)
    sheet = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    return shapes.between(sheet, sheet + np.array((0.0, 0.0, 0.012)))


def banner() -> Solid:
    """A cloth hung over the balustrade towards the court, with soft vertical folds and a pointed hem."""
    t = np.linspace(0.0, 1.0, 13)[:, None]
    s = np.linspace(-1.0, 1.0, 19)
    x = 0.52 * s * (1.0 - 0.04 * t)
    y = UPPER.base + 0.81 - (1.62 + 0.28 * (1.0 - np.abs(s))) * t
    over = np.minimum(t * 12.0, 1.0)  # over the rail, then down
    z = -0.05 - WALL_THICKNESS / 2.0 - 0.36 + 0.42 * (1.0 - over) + t * 0.035 * np.sin(7.0 * s + 1.0)
    sheet = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    return shapes.between(sheet, sheet + np.array((0.0, 0.004, -0.010)))


def fountain_profiles() -> list[npt.NDArray[np.float64]]:
    """Outlines for the lathe: the basin with its water-deep hollow, the stem with the upper bowl, the finial."""
    basin = _curve([(0.80, 0.0), (0.84, 0.10), (0.92, 0.38), (0.97, 0.50)], 3)
    rim = np.array([(0.97, 0.54), (0.86, 0.54), (0.82, 0.30), (0.0, 0.26)])
    stem = _curve(
        [
            (0.30, 0.26),
            (0.20, 0.36),
            (0.12, 0.55),
            (0.17, 0.75),
            (0.11, 0.95),
            (0.14, 1.05),
            (0.34, 1.13),
            (0.52, 1.27),
        ],
        3,
    )
    bowl = np.array([(0.54, 1.30), (0.48, 1.30), (0.30, 1.18), (0.0, 1.14)])
    finial = _curve(
        [(0.10, 1.14), (0.06, 1.22), (0.05, 1.34), (0.12, 1.46), (0.10, 1.58), (0.03, 1.66), (0.0, 1.76)], 3
    )
    return [np.vstack([basin, rim]), np.vstack([stem, bowl]), finial]


def ashlar_texture(size: int = 256) -> npt.NDArray[np.uint8]:
    """(size, size, 4) uint8 sRGB: four courses of four stones, dark joints, every stone of its own tone."""
    rng = np.random.default_rng(1)
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 4.0
    course = y.astype(int)
    along = (x + 0.5 * (course % 2)) % 4.0
    tone = rng.uniform(0.90, 1.06, (4, 4))[course, along.astype(int)]
    to_joint = np.minimum(np.minimum(y % 1.0, 1.0 - y % 1.0), np.minimum(along % 1.0, 1.0 - along % 1.0))
    joint = np.clip((to_joint - 0.012) / 0.015, 0.0, 1.0)
    grain = 1.0 + 0.035 * _smooth_noise(rng, size, 8) + 0.02 * rng.normal(size=(size, size))
    return _picture((208.0, 190.0, 160.0), tone * grain * (0.78 + 0.22 * joint))


def paving_texture(size: int = 256) -> npt.NDArray[np.uint8]:
    """(size, size, 4) uint8 sRGB: light square slabs with dark lozenges at their corners."""
    rng = np.random.default_rng(2)
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 2.0
    to_corner = np.abs(x - np.round(x)) + np.abs(y - np.round(y))
    to_joint = np.minimum(np.abs(x - np.round(x)), np.abs(y - np.round(y)))
    light = 1.0 - 0.25 * np.clip(1.0 - (to_joint - 0.006) / 0.01, 0.0, 1.0)
    light = np.where(to_corner < 0.20, 0.42, light)
    light *= rng.uniform(0.92, 1.05, (2, 2))[y.astype(int), x.astype(int)]
    return _picture((196.0, 182.0, 160.0), light * (1.0 + 0.04 * _smooth_noise(rng, size, 16)))


def _smooth_noise(rng: np.random.Generator, size: int, cells: int) -> npt.NDArray[np.float64]:
    """(size, size) noise of zero mean that repeats at its borders, `cells` bumps along a side."""
    spectrum = np.fft.fft2(rng.normal(size=(size, size)))
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size))) * size
    noise = np.fft.ifft2(spectrum * np.exp(-((frequency / cells) ** 2))).real
    return noise / noise.std()


def _picture(color: tuple[float, float, float], light: npt.NDArray[np.float64]) -> npt.NDArray[np.uint8]:
    rgb = np.array(color) * light[..., None]
    return np.dstack([rgb, np.full(light.shape, 255.0)]).round().clip(0, 255).astype(np.uint8)
