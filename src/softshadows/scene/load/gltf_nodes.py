"""The glTF node hierarchy as world matrices, without recursion: hierarchies may be 100 000 nodes deep."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from softshadows.scene.load.checked_json import Item


def world_nodes(root: Item) -> Iterator[tuple[Item, np.ndarray]]:
    """The nodes of the default scene, parents first, each with its local-to-world matrix (4, 4) float64.

    Without a `scene` the first scene is taken; without any scene, all root nodes. Raises SceneError for loops
    (NODE_LOOP), second parents (NODE_PARENT_OVERRIDE) and transforms that are not finite or not affine.
    """
    nodes = root.objects("nodes")
    children = [node.indices("children", len(nodes), "node") for node in nodes]
    has_parent = _check_tree(nodes, children)
    pending = [(index, np.eye(4)) for index in reversed(_scene_roots(root, nodes, has_parent))]
    while pending:
        index, parent = pending.pop()
        with np.errstate(over="ignore", invalid="ignore"):
            world = parent @ _local_matrix(nodes[index])
        if not np.isfinite(world).all():
            raise nodes[index].error("NODE_MATRIX_INVALID", "the world transform is not finite")
        yield nodes[index], world
        pending += [(child, world) for child in reversed(children[index])]


def _check_tree(nodes: list[Item], children: list[list[int]]) -> list[bool]:
    """Whether each node has a parent. Raises SceneError unless the nodes form disjoint trees."""
    has_parent = [False] * len(nodes)
    for node, its_children in zip(nodes, children, strict=True):
        for child in its_children:
            if has_parent[child]:
                raise node.error("NODE_PARENT_OVERRIDE", f"node {child} already has a parent", "children")
            has_parent[child] = True
    reached, pending = 0, [index for index, parented in enumerate(has_parent) if not parented]
    while pending:
        reached += 1
        pending += children[pending.pop()]
    if reached < len(nodes):  # with one parent each, only nodes in loops cannot be reached from a root
        culprit = _node_in_loop(children, has_parent)
        raise nodes[culprit].error("NODE_LOOP", f"node {culprit} is its own ancestor or descends from such a node")
    return has_parent


def _node_in_loop(children: list[list[int]], has_parent: list[bool]) -> int:
    outside = [False] * len(children)
    pending = [index for index, parented in enumerate(has_parent) if not parented]
    while pending:
        index = pending.pop()
        outside[index] = True
        pending += children[index]
    return outside.index(False)


def _scene_roots(root: Item, nodes: list[Item], has_parent: list[bool]) -> list[int]:
    scenes = root.objects("scenes")
    if "scene" not in root and not scenes:
        return [index for index, parented in enumerate(has_parent) if not parented]
    scene = scenes[root.index("scene", len(scenes), "scene") if "scene" in root else 0]
    roots = scene.indices("nodes", len(nodes), "node")
    for index in roots:
        if has_parent[index]:
            raise scene.error("SCENE_NON_ROOT_NODE", f"node {index} is a child of another node", "nodes")
    if len(set(roots)) != len(roots):
        raise scene.error("DUPLICATE_ELEMENTS", "a node is named twice", "nodes")
    return roots


def _local_matrix(node: Item) -> np.ndarray:
    if "matrix" in node:
        if any(key in node for key in ("translation", "rotation", "scale")):
            raise node.error(
                "NODE_MATRIX_TRS", "a node has either a matrix or translation, rotation and scale", "matrix"
            )
        matrix = np.array(node.numbers("matrix", 16)).reshape(4, 4).T
        if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0), atol=1e-6):
            raise node.error("NODE_MATRIX_NON_TRS", "the matrix is not affine: its last row must be 0 0 0 1", "matrix")
        matrix[3] = (0.0, 0.0, 0.0, 1.0)
        return matrix
    matrix = np.eye(4)
    if "rotation" in node:
        matrix[:3, :3] = _rotation(node)
    if "scale" in node:
        matrix[:3, :3] *= node.numbers("scale", 3)
    if "translation" in node:
        matrix[:3, 3] = node.numbers("translation", 3)
    return matrix


def _rotation(node: Item) -> np.ndarray:
    x, y, z, w = node.numbers("rotation", 4, low=-2.0, high=2.0)
    length = (x * x + y * y + z * z + w * w) ** 0.5
    if not 0.5 <= length <= 2.0:
        raise node.error("ROTATION_NON_UNIT", f"the quaternion's length must be 1, it is {length:.3g}", "rotation")
    x, y, z, w = x / length, y / length, z / length, w / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
