"""The tree of the scene's triangles: its form, its builders, and what it does when nodes move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

import softshadows as ss
from softshadows.errors import OptionError
from softshadows.gpu.commands import Commands
from softshadows.gpu.device import acquire
from softshadows.gpu.layout import dtype
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import PassTimer
from softshadows.scene.geometry import flatten
from softshadows.scene.solids import is_solid
from softshadows.truth.occluders import Occluders
from softshadows.visibility.rays.cast import Caster
from softshadows.visibility.rays.grid import TreeGrid
from softshadows.visibility.rays.lbvh import BLOCK, DIGITS
from softshadows.visibility.rays.sah import shape_by_area
from softshadows.visibility.rays.shape import LEAF, LEAF_COUNT_SHIFT, MOST_IN_LEAF, Shape
from softshadows.visibility.rays.tree import BUILDERS, Bvh
from stage import CAMERA, SIZE, box, moved, render, same_bits, standard_scene

CPU_GPU = [builder for builder in BUILDERS if builder != "auto"]
PLACES = (1 << LEAF_COUNT_SHIFT) - 1


@dataclass
class Tree:
    """What the walk reads: boxes' low and high corners, (n, 3) cells; links; (t, 3, 3) triangles; their numbers."""

    low: npt.NDArray[np.int64]
    high: npt.NDArray[np.int64]
    link: npt.NDArray[np.int64]
    triangles: npt.NDArray[np.float32]
    order: npt.NDArray[np.uint32]
    grid: np.void

    @property
    def is_leaf(self) -> npt.NDArray[np.bool_]:
        return self.link >= LEAF

    @property
    def counts(self) -> npt.NDArray[np.int64]:
        """By leaf: its triangles."""
        return (self.link[self.is_leaf] >> LEAF_COUNT_SHIFT & MOST_IN_LEAF - 1) + 1


def upload(scene: ss.Scene, profile: str = "full") -> SceneBuffers:
    return SceneBuffers(acquire(profile), flatten(scene))


def build(buffers: SceneBuffers, builder: str) -> Bvh:
    tree = Bvh(buffers, builder)
    encode(buffers, tree)
    return tree


def encode(buffers: SceneBuffers, tree: Bvh) -> None:
    commands = Commands(buffers.gpu, PassTimer(buffers.gpu))
    tree.encode(commands)
    commands.submit()


def read(buffers: SceneBuffers, tree: Bvh) -> Tree:
    queue = buffers.gpu.device.queue
    grid = np.asarray(queue.read_buffer(tree.grid, 0, dtype(TreeGrid).itemsize)).view(dtype(TreeGrid))[0]
    nodes = np.asarray(queue.read_buffer(tree.nodes)).view(np.uint32).reshape(-1, 4)[: grid["node_count"]]
    places = np.asarray(queue.read_buffer(tree.triangles)).view(np.float32)[: 12 * buffers.triangle_count]
    corners = places.reshape(-1, 3, 4)
    box = nodes[:, :3].astype(np.int64)
    order = np.ascontiguousarray(corners[:, 0, 3]).view(np.uint32)
    return Tree(box & 0xFFFF, box >> 16, nodes[:, 3].astype(np.int64), corners[..., :3], order, grid)


def check(buffers: SceneBuffers, tree: Bvh) -> Tree:
    """Everything that makes it a tree over the scene's triangles as they lie now."""
    found, geometry = read(buffers, tree), buffers.geometry
    count = len(found.link)
    np.testing.assert_array_equal(np.sort(found.order), np.arange(buffers.triangle_count))
    np.testing.assert_array_equal(found.triangles, geometry.positions[geometry.triangles[found.order]])

    # Leaf after leaf holds all places.
    leaves = np.flatnonzero(found.is_leaf)
    ends = np.cumsum(found.counts)
    np.testing.assert_array_equal(found.link[leaves] & PLACES, ends - found.counts)
    assert ends[-1] == buffers.triangle_count

    # A node's children follow it, fill its tree and its box.
    after = np.where(found.is_leaf, np.arange(count) + 1, found.link)
    inner = np.flatnonzero(~found.is_leaf)
    first = inner + 1
    second = after[first]
    assert after[0] == count
    np.testing.assert_array_equal(after[second], after[inner])
    np.testing.assert_array_equal(found.low[inner], np.minimum(found.low[first], found.low[second]))
    np.testing.assert_array_equal(found.high[inner], np.maximum(found.high[first], found.high[second]))

    # A leaf's box holds its triangles, with room for the rounding of rays, and little more.
    cells = (found.triangles.astype(np.float64) - found.grid["low_ws"]) * found.grid["cells_per_metre"]
    starts = ends - found.counts
    low = np.minimum.reduceat(cells.min(axis=1), starts, axis=0)
    high = np.maximum.reduceat(cells.max(axis=1), starts, axis=0)
    room_below, room_above = low - found.low[leaves], found.high[leaves] - high
    for room in (room_below, room_above):
        assert room.min() >= 1.0 / 64.0
        assert room.max() <= 1.1
    return found


def surface_cost(found: Tree) -> float:
    """What the surface-area heuristic expects a ray to cost, over the root's surface."""
    x, y, z = ((found.high - found.low) / found.grid["cells_per_metre"]).T.astype(np.float64)
    area = x * y + y * z + z * x
    tested = area[found.is_leaf] @ found.counts
    return float((area[~found.is_leaf].sum() + tested) / area[0])


def soup(count: int, seed: int = 0) -> ss.Scene:
    """Triangles that share nothing."""
    corners = np.random.default_rng(seed).normal(size=(3 * count, 3)).astype(np.float32)
    return of_corners(corners)


def of_corners(corners: npt.NDArray[np.float32]) -> ss.Scene:
    return ss.Scene([ss.Node(ss.Mesh(corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)))])


def rays_through(buffers: SceneBuffers, count: int, seed: int = 0) -> tuple[npt.NDArray, npt.NDArray]:
    """Four segments from each of `count` points in the scene's box to others in it."""
    random = np.random.default_rng(seed)
    low, high = buffers.geometry.bounds
    origins = random.uniform(low, high, (count, 3)).astype(np.float32)
    ends = random.uniform(low, high, (count, 4, 3))
    return origins, (ends - origins[:, None]).astype(np.float32)


def blocked_in_truth(buffers: SceneBuffers, origins: npt.NDArray, rays: npt.NDArray) -> npt.NDArray[np.bool_]:
    starts = np.broadcast_to(origins[:, None], rays.shape)
    return Occluders(buffers.geometry).blocked_along(starts, rays)


@pytest.mark.parametrize("builder", CPU_GPU)
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9, 1000, 2 * BLOCK + 1])
def test_a_tree_over_any_number_of_triangles(count: int, builder: str) -> None:
    buffers = upload(soup(count))
    found = check(buffers, build(buffers, builder))
    assert len(found.link) <= max(2 * count - 1, 1)
    assert found.counts.max() <= MOST_IN_LEAF


@pytest.mark.parametrize("builder", BUILDERS)
def test_a_scene_without_triangles_has_a_tree_without_nodes(builder: str) -> None:
    buffers = upload(ss.Scene())
    tree = build(buffers, builder)
    assert read(buffers, tree).grid["node_count"] == 0
    assert not Caster(buffers, tree).blocked(np.zeros((3, 3), np.float32), np.ones((3, 4, 3), np.float32)).any()


@pytest.mark.parametrize("builder", CPU_GPU)
@pytest.mark.parametrize(
    "case", ["one point", "one triangle again and again", "flat", "a line", "tiny and far away", "vast"]
)
def test_degenerate_triangles_have_a_tree(case: str, builder: str) -> None:
    corners = np.random.default_rng(1).normal(size=(300, 3)).astype(np.float32)
    corners = {
        "one point": np.full_like(corners, 3.0),
        "one triangle again and again": np.tile(corners[:3], (100, 1)),
        "flat": corners * np.array([1, 0, 1], np.float32),
        "a line": corners[:, :1] * np.array([1, 2, 3], np.float32),
        "tiny and far away": np.float32(1e-2) * corners + np.array([1e4, 0, -1e4], np.float32),
        "vast": np.float32(1e11) * corners,
    }[case]
    buffers = upload(of_corners(corners))
    tree = build(buffers, builder)
    found = check(buffers, tree)
    assert np.isfinite(found.grid["cells_per_metre"]).all()


@pytest.mark.parametrize("name", ["sphere_cube", "leaves", "fence", "atrium"])
def test_both_builders_answer_as_the_truth_does(name: str) -> None:
    """Which tree a ray walks through does not matter to the bit; Embree may differ where a ray meets an edge."""
    buffers = upload(ss.scenes.SCENES[name]())
    origins, rays = rays_through(buffers, 2000)
    by_cpu, by_gpu = (Caster(buffers, build(buffers, builder)).blocked(origins, rays) for builder in CPU_GPU)
    np.testing.assert_array_equal(by_cpu, by_gpu)
    assert 0.01 < by_cpu.mean() < 0.99
    assert (by_cpu != blocked_in_truth(buffers, origins, rays)).mean() <= 2e-4


@pytest.mark.parametrize("profile", ["full", "portable"])
def test_the_gpu_sorts_more_blocks_than_a_workgroup_has_lanes(profile: str) -> None:
    """Points in a cube whose grid has cells of one metre, so that codes are exact; each twice, in blocks far apart."""
    count = BLOCK * DIGITS // 2 + 10_000
    points = np.random.default_rng(3).integers(0, 65532, (count, 3))
    points[:2] = [[0, 0, 0], [65531, 65531, 65531]]
    points = np.concatenate([points, points])
    places = np.repeat(np.arange(len(points), dtype=np.uint32), 3).reshape(-1, 3)
    buffers = upload(ss.Scene([ss.Node(ss.Mesh(points.astype(np.float32), places))]), profile)
    found = check(buffers, build(buffers, "gpu"))
    assert (found.grid["cells_per_metre"] == 1.0).all()

    cell = (points + 2) // 2  # past the margin; a code's cells are two of the grid's
    code = np.zeros(len(cell), np.int64)
    for bit in range(15):
        for axis in range(3):
            code |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    np.testing.assert_array_equal(found.order, np.argsort(code, kind="stable"))


@pytest.mark.parametrize(("name", "ratio"), [("sphere_cube", 1.1), ("figures", 1.1), ("room", 2.0)])
def test_the_gpus_trees_cost_little_more_than_the_cpus(name: str, ratio: float) -> None:
    """By the heuristic's measure; docs/decisions/0017-rays.md has measured speeds."""
    buffers = upload(ss.scenes.SCENES[name]())
    by_cpu, by_gpu = (surface_cost(read(buffers, build(buffers, builder))) for builder in CPU_GPU)
    assert by_gpu < ratio * by_cpu


def restless(nodes: int, seed: int) -> tuple[ss.Scene, np.random.Generator]:
    """A floor, a card and many boxes of one mesh."""
    random = np.random.default_rng(seed)
    scene = standard_scene()
    scene.nodes += [moved(scene.nodes[2], random.uniform(-2.0, 2.0, 3).tolist()) for _ in range(nodes)]
    return scene, random


def move_some(scene: ss.Scene, random: np.random.Generator) -> None:
    """Up to three nodes go somewhere else, turned and bent, and now and then flattened, which changes the triangles'
    order."""
    for index in random.choice(len(scene.nodes), random.integers(0, 4), replace=False):
        transform = np.eye(4)
        transform[:3, :3] = random.normal(size=(3, 3)) * (1.0, 1.0, random.choice([1.0, 0.0], p=[0.7, 0.3]))
        transform[:3, 3] = random.uniform(-3.0, 3.0, 3)
        scene.nodes[index].transform = transform


@pytest.mark.parametrize("builder", CPU_GPU)
@pytest.mark.parametrize("seed", [0, 1])
def test_after_any_moves_the_tree_is_whole_and_answers_as_the_truth_does(builder: str, seed: int) -> None:
    scene, random = restless(12, seed)
    buffers = upload(scene)
    tree = build(buffers, builder)
    caster = Caster(buffers, tree)
    orders = set()
    for _ in range(12):
        move_some(scene, random)
        buffers.move(flatten(scene))
        encode(buffers, tree)
        check(buffers, tree)
        origins, rays = rays_through(buffers, 500, seed)
        assert (caster.blocked(origins, rays) != blocked_in_truth(buffers, origins, rays)).sum() <= 1
        orders.add(tuple(id(mesh) for mesh in buffers.geometry.meshes))
    assert len(orders) > 1, "no node became flat, so that the order of triangles never changed"


def test_a_renderer_in_which_nodes_move_renders_as_a_new_one_does() -> None:
    scene = standard_scene()
    technique = ss.techniques.Adaptive(visibility="ray")
    with ss.Renderer(scene, technique=technique, size=SIZE) as renderer:
        for node in (*scene.nodes, *scene.nodes):
            frame = renderer.render(CAMERA)
            assert same_bits(frame.visibility, render(scene, technique).visibility)
            node.transform = node.transform + np.outer([0.1, 0.05, -0.1, 0.0], [0.0, 0.0, 0.0, 1.0])


def test_all_nodes_may_move_and_come_back() -> None:
    scene, random = restless(5, 3)
    buffers = upload(scene)
    tree = build(buffers, "cpu")
    rest = [node.transform for node in scene.nodes]
    for _ in range(3):
        for node in scene.nodes:
            node.transform = node.transform.copy()
            node.transform[:3, 3] += random.uniform(-5.0, 5.0, 3)
        buffers.move(flatten(scene))
        encode(buffers, tree)
        check(buffers, tree)
    for node, transform in zip(scene.nodes, rest, strict=True):
        node.transform = transform
    buffers.move(flatten(scene))
    encode(buffers, tree)
    assert surface_cost(check(buffers, tree)) < 1.3 * surface_cost(read(buffers, build(buffers, "cpu")))


def boxes(count: int) -> ss.Scene:
    """Boxes of many shapes, far from each other."""
    random = np.random.default_rng(8)
    lows = random.uniform(-10.0, 10.0, (count, 3))
    sizes = random.uniform(0.05, 0.3, (count, 3))
    return ss.Scene([box(low, low + size) for low, size in zip(lows, sizes, strict=True)])


@pytest.mark.parametrize(("builder", "ratio"), [("cpu", 1.4), ("gpu", 1.0)])
def test_what_moves_far_leaves_no_long_boxes_behind(builder: str, ratio: float) -> None:
    """Boxes go somewhere else, again and again: the tree costs rays little more than a new one. By the CPU it is two
    trees in one place, at rest and moved."""
    scene, random = boxes(100), np.random.default_rng(5)
    buffers = upload(scene)
    tree = build(buffers, builder)
    for _ in range(3):
        for node in scene.nodes[20:]:
            node.transform = np.eye(4)
            node.transform[:3, 3] = random.uniform(-10.0, 10.0, 3)
        buffers.move(flatten(scene))
        encode(buffers, tree)
        assert surface_cost(check(buffers, tree)) <= ratio * surface_cost(read(buffers, build(buffers, builder)))


def test_a_node_that_becomes_flat_leaves_the_other_trees_as_they_are() -> None:
    """It is no longer solid, so that all triangles after it have other numbers."""
    scene = ss.scenes.figures()
    scene.nodes = [node for node in scene.nodes if is_solid(node.mesh)]
    buffers = upload(scene)
    tree = build(buffers, "cpu")
    scene.nodes[0].transform = np.diag([1.0, 0.0, 1.0, 1.0])
    buffers.move(flatten(scene))
    encode(buffers, tree)
    assert buffers.solid_count < buffers.triangle_count
    assert surface_cost(check(buffers, tree)) < 1.1 * surface_cost(read(buffers, build(buffers, "cpu")))


def test_the_trees_without_some_triangles_is_a_tree_over_the_others() -> None:
    random = np.random.default_rng(2)
    low = random.normal(size=(3, 500)).astype(np.float32)
    whole = shape_by_area(low, low + np.float32(0.1))
    for share in (0.0, 0.01, 0.5, 0.99, 1.0):
        stays = random.random(500) < share
        part = whole.only(stays)
        np.testing.assert_array_equal(part.order, whole.order[stays])
        assert (part.end > part.first).all()
        assert len(part.first) == max(2 * np.count_nonzero(part.is_leaf) - 1, 0)  # two children each: none is in vain
        if len(part.first):
            assert part.skip[0] == len(part.first)
            assert part.end[0] == len(part.order)
    assert not len(Shape.empty().records())


def test_an_unknown_builder_is_refused() -> None:
    with pytest.raises(OptionError, match="builder must be one of auto, cpu, gpu, got 'sah'"):
        Bvh(upload(soup(1)), "sah")


def test_a_tree_follows_only_what_has_changed() -> None:
    """The same geometry again encodes nothing."""
    buffers = upload(soup(10))
    tree = build(buffers, "cpu")
    commands = Commands(buffers.gpu, PassTimer(buffers.gpu))
    tree.encode(commands)
    assert not commands.timer.names
