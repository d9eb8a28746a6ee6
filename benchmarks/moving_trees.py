"""What it costs to keep a tree while nodes move, and what rays cost then.

    python benchmarks/moving_trees.py sponza_near.toml 25     the 25 largest nodes of a shot or built-in scene; or 0

Three trees follow the same moves: with parts, as the renderer's; only refitted; and new, by the CPU and by the GPU.
Milliseconds of the first move and the median of later ones, and rays per second after the last.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np

from softshadows.bench.tree_times import rays_to_light
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import PassTimer
from softshadows.scene.geometry import flatten
from softshadows.scene.model import Node
from softshadows.scene.shot import open_shot
from softshadows.visibility.rays.cast import PACKET, Caster
from softshadows.visibility.rays.tree import Bvh

MOVES = 6
REACH = 0.15
"""How far nodes move along each axis at most, of the scene's box; a tenth of it upwards."""


def encode(tree: Bvh) -> float:
    """Bring it up to date, in milliseconds."""
    gpu = acquire()
    started = time.perf_counter()
    commands = Commands(gpu, PassTimer(gpu))
    tree.encode(commands)
    commands.submit()
    gpu.device.queue.read_buffer(tree.grid)
    return 1e3 * (time.perf_counter() - started)


def move(node: Node, random: np.random.Generator, size: np.ndarray) -> None:
    """Turn it about the vertical axis and put it elsewhere."""
    angle = random.uniform(0.0, 1.0)
    turn = np.eye(4)
    turn[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    turn[:3, 3] = random.uniform(-REACH, REACH, 3) * size * (1.0, 0.1, 1.0)
    node.transform = turn @ node.transform


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scene")
    arguments.add_argument("nodes", type=int)
    given = arguments.parse_args()
    scene = open_shot(given.scene).scene
    restless = sorted(scene.nodes, key=lambda node: -len(node.mesh.triangles))[: given.nodes]
    geometry = flatten(scene)
    buffers = SceneBuffers(acquire(), geometry)
    with_parts, refitted = Bvh(buffers, "cpu"), Bvh(buffers, "cpu")
    trees = {"with parts": with_parts, "refitted": refitted}
    for tree in trees.values():
        encode(tree)
    assert refitted._parts is not None
    refitted._parts._moves.follow = lambda geometry: False  # it hears of no move, and finds new boxes alone

    random, times = np.random.default_rng(0), {name: [] for name in trees}
    for _ in range(MOVES):
        for node in restless:
            move(node, random, geometry.bounds[1] - geometry.bounds[0])
        buffers.move(flatten(scene))
        for name, tree in trees.items():
            times[name].append(encode(tree))
    for name, taken in times.items():
        print(f"{name}: first move {taken[0]:.1f} ms, later ones {statistics.median(taken[1:]):.1f} ms")

    for builder in ("cpu", "gpu"):
        trees[f"new, {builder}"] = Bvh(buffers, builder)
    casters = {name: Caster(buffers, tree) for name, tree in trees.items()}
    origins, rays = rays_to_light(buffers.geometry, 20_000)
    for caster in casters.values():
        caster.blocked(origins, rays)  # compiles
    speeds = {name: [] for name in casters}
    for _ in range(5):
        for name, caster in casters.items():
            caster.blocked(origins, rays)
            speeds[name].append(PACKET * len(origins) / caster.seconds / 1e6)
    for name, speed in speeds.items():
        print(f"{name}: {statistics.median(speed):.2f} million rays/s ({min(speed):.2f} to {max(speed):.2f})")


if __name__ == "__main__":
    main()
