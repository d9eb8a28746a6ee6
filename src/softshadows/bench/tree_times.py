"""How long trees take to build, to fit and to walk: the numbers of `bench rays` about `visibility/rays`."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import PassTimer
from softshadows.scene.camera import Camera
from softshadows.scene.clusters import along_curve
from softshadows.scene.geometry import Geometry, flatten
from softshadows.scene.lights import RectLight
from softshadows.scene.model import Mesh, Node, Scene
from softshadows.visibility.rays.cast import PACKET, Caster
from softshadows.visibility.rays.parts import Parts
from softshadows.visibility.rays.tree import Bvh

Floats = npt.NDArray[np.float32]

SIDE = 100.0
"""Metres along a side of the terrain."""
ROUGHNESS = 0.5
"""Amplitude of the heights' waves over that of waves twice as long."""
LIGHT_HALF = 2.0
LIGHT_HEIGHT = 20.0
"""Metres: the light that rays go to, a square over the middle."""
SEED = 1
SUN = RectLight((15.0, 30.0, 10.0), (0.0, 0.0, 0.0), 6.0, 6.0, (100.0, 100.0, 100.0))
OVER_HILLS = Camera((0.0, 30.0, 60.0), (0.0, 0.0, 0.0), 45.0)


@dataclass(frozen=True)
class TreeTimes:
    """Medians for one scene and one builder. `build_ms`: the tree's shape and its boxes; `follow_ms`: the boxes alone,
    which is what follows a move, or all of it where the GPU builds."""

    triangles: int
    builder: str
    megabytes: float
    build_ms: float
    follow_ms: float
    rays_per_second: float


def terrain(triangles: int) -> Scene:
    """Hills of about so many triangles, as one mesh."""
    if triangles < 2:
        raise OptionError(f"a terrain has at least 2 triangles, got {triangles}")
    cells = max(round((triangles / 2) ** 0.5), 1)
    x, z = np.meshgrid(*[np.linspace(-0.5, 0.5, cells + 1)] * 2)
    random = np.random.default_rng(SEED)
    y = np.zeros_like(x)
    for octave in range(8):
        for (kx, kz), phase in zip(
            random.normal(0.0, 2.0 * 2.0**octave, (4, 2)), random.uniform(0, 6.3, 4), strict=True
        ):
            y += 0.02 * ROUGHNESS**octave * np.sin(2.0 * np.pi * (kx * x + kz * z) + phase)
    corner = np.arange(cells * (cells + 1)).reshape(cells, -1)[:, :-1].ravel()
    right, below = corner + 1, corner + cells + 1
    faces = np.concatenate([np.stack([corner, below, right], axis=1), np.stack([right, below, below + 1], axis=1)])
    positions = SIDE * np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return Scene([Node(Mesh(positions.astype(np.float32), faces.astype(np.uint32), name="terrain"))], name="terrain")


def time_tree(scene: Scene, builder: str, *, packets: int = 1 << 16, repeats: int = 3) -> TreeTimes:
    """Build, follow and walk, each `repeats` times, with shaders compiled before. Raises OptionError as Bvh."""
    geometry = flatten(scene)
    buffers = SceneBuffers(acquire(), geometry)
    shapes, follows, walks = [0.0], [], []
    tree = Bvh(buffers, builder)
    _encode(tree)
    for _ in range(repeats):
        if builder == "cpu":
            shapes.append(_milliseconds(lambda: Parts(geometry)))
        buffers.geometry = flatten(scene)  # equal, but another one, which the tree must look at
        follows.append(_milliseconds(lambda: _encode(tree)))
    caster, (origins, rays) = Caster(buffers, tree), rays_to_light(geometry, packets)
    for _ in range(repeats):
        caster.blocked(origins, rays)
        walks.append(PACKET * len(origins) / caster.seconds)
    follow_ms = statistics.median(follows)
    build_ms = statistics.median(shapes[1:] or shapes) + follow_ms
    return TreeTimes(len(geometry.triangles), builder, tree.bytes / 1e6, build_ms, follow_ms, statistics.median(walks))


def rays_to_light(geometry: Geometry, packets: int) -> tuple[Floats, Floats]:
    """Segments from points just above the surface to a light over the middle, as `Caster.blocked` takes them; points
    that follow each other lie close together, as pixels do."""
    random = np.random.default_rng(SEED)
    triangle = random.integers(0, len(geometry.triangles), packets)
    corners = geometry.positions[geometry.triangles[triangle]]
    normals = geometry.face_normals[triangle]
    weights = random.dirichlet((1.0, 1.0, 1.0), packets)
    origins = np.einsum("nk,nkc->nc", weights, corners) + 1e-4 * normals
    origins = origins[along_curve(origins.T.astype(np.float32))]
    points = random.uniform(-LIGHT_HALF, LIGHT_HALF, (packets, PACKET, 3))
    points[..., 1] = LIGHT_HEIGHT
    rays = geometry.bounds.mean(axis=0) + points - origins[:, None]
    return origins.astype(np.float32), rays.astype(np.float32)


def _milliseconds(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - started)


def _encode(tree: Bvh) -> None:
    """Bring the tree up to date, and wait."""
    gpu = acquire()
    commands = Commands(gpu, PassTimer(gpu))
    tree.encode(commands)
    commands.submit()
    gpu.device.queue.read_buffer(tree.grid)
