"""Small scenes and cheap settings for tests that render."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

import softshadows as ss
from softshadows.techniques import TECHNIQUES, Technique

SIZE = (48, 36)
WHITE = (1.0, 1.0, 1.0)
MATT = ss.Material("matt", double_sided=True)
FLOOR_HALF = 3.0
CHEAP = {"resolution": 256, "grid": 4}
"""Options that make a test fast, set where a technique has them."""

CAMERA = ss.Camera((1.3, 2.3, 2.9), (0.05, 0.3, 0.05), 45.0)
RECT = ss.RectLight((0.4, 4.0, 0.3), (0.1, 0.0, 0.0), 0.8, 0.5, (10.0, 10.0, 10.0))
LIGHTS = {
    "rect": RECT,
    "line": ss.LineLight((-0.1, 4.0, 0.3), (0.9, 4.1, 0.2), WHITE),
    "disk": ss.DiskLight((0.4, 4.0, 0.3), (0.1, 0.0, 0.0), 0.4, WHITE),
    "point": ss.PointLight((0.4, 4.0, 0.3), WHITE),
    "spot": ss.SpotLight((0.4, 4.0, 0.3), (0.1, 0.0, 0.0), WHITE, 20.0, 60.0),
    "directional": ss.DirectionalLight((-0.1, -1.0, -0.07), WHITE),
}
"""One light of every kind, each about above the middle of the floor."""


def light_for(name: str) -> Any:
    """A light that the technique called `name` can do, one with a size where it can."""
    return next(light for kind, light in LIGHTS.items() if kind in TECHNIQUES[name].light_kinds)


def cheap(name: str, **options: Any) -> Technique:
    """The technique called `name` with few and small shadow maps, where it draws any."""
    cls = TECHNIQUES[name]
    known = {option.name for option in cls.options()}
    if options.get("visibility") == "ray":
        options = {**options, "resolution": "auto"}
    return cls.of({key: value for key, value in {**CHEAP, **options}.items() if key in known})


def quad(corners: Sequence[Sequence[float]], material: ss.Material = MATT, name: str = "") -> ss.Node:
    """A quadrilateral through four corners."""
    mesh = ss.Mesh(np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material=material)
    return ss.Node(mesh, name=name)


def floor(half: float = FLOOR_HALF, height: float = 0.0) -> ss.Node:
    """A horizontal square that faces up."""
    y = height
    return quad([(-half, y, -half), (-half, y, half), (half, y, half), (half, y, -half)], name="floor")


def card(x0: float, x1: float, z0: float, z1: float, height: float) -> ss.Node:
    """A horizontal rectangle without thickness."""
    return quad([(x0, height, z0), (x0, height, z1), (x1, height, z1), (x1, height, z0)], name="card")


def box(low: Sequence[float], high: Sequence[float], material: ss.Material = MATT) -> ss.Node:
    """A closed box, its faces outward."""
    corners = np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)], np.float32)
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = [triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))]
    return ss.Node(ss.Mesh(corners, np.array(triangles, np.uint32), material=material), name="box")


def moved(node: ss.Node, offset: Sequence[float]) -> ss.Node:
    """The same mesh elsewhere."""
    transform = np.eye(4)
    transform[:3, 3] = offset
    return ss.Node(node.mesh, transform, node.name)


def standard_scene(light: Any = RECT) -> ss.Scene:
    """A floor, a card above it and a box on it, with no symmetry: penumbra, umbra, contact and self-shadowing."""
    nodes = [floor(), card(-0.9, 0.2, -0.7, 0.45, 1.1), box((0.55, 0.0, -0.35), (1.2, 0.8, 0.5))]
    return ss.Scene(nodes, [light], CAMERA)


def render(
    scene: ss.Scene, technique: Technique | str, size: tuple[int, int] = SIZE, camera: ss.Camera | None = None
) -> ss.Frame:
    """A frame by a renderer of its own."""
    return ss.render(scene, camera or scene.camera or CAMERA, technique=technique, size=size)


def drawn(renderer: ss.Renderer, camera: ss.Camera) -> ss.Frame:
    """A frame as `draw` makes the first of a picture, with maps that may have been fitted before, and read back."""
    with renderer._frame(camera, keeps_looser_fits=True) as (passes, commands):
        passes.readback.encode(commands.encoder)
    return renderer.read()


def same_bits(a: npt.NDArray[np.float32], b: npt.NDArray[np.float32]) -> bool:
    """Equal shapes and equal bit patterns."""
    return a.shape == b.shape and np.array_equal(a.view(np.uint32), b.view(np.uint32))


def has_nan_or_inf(image: npt.NDArray[np.float32]) -> bool:
    """By bit pattern, so that no compiler can reason it away."""
    return bool(((np.ascontiguousarray(image).view(np.uint32) & 0x7F800000) == 0x7F800000).any())


def check_visibility(frame: ss.Frame) -> None:
    """What holds for every frame: visibility finite and in [0, 1], 1 where there is no surface; finite colours."""
    assert frame.visibility.dtype == np.float32
    assert frame.visibility.shape == (len(frame.lights), *frame.surface.shape)
    assert not has_nan_or_inf(frame.visibility)
    assert not has_nan_or_inf(frame.color)
    assert (frame.visibility >= 0.0).all()
    assert (frame.visibility <= 1.0).all()
    assert (frame.visibility[:, ~frame.surface] == 1.0).all()
