"""A small tree of alpha-masked cards: the shadow's edge lies in the texture, not in the triangles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from softshadows.scene.builtin import shapes
from softshadows.scene.camera import Camera
from softshadows.scene.framing import rect_light
from softshadows.scene.model import Material, Mesh, Node, Scene, Texture

BARK = Material("bark", (0.20, 0.13, 0.08, 1.0), roughness=0.95)
SOIL = Material("soil", (0.66, 0.62, 0.54, 1.0), roughness=0.95)
CLAY = Material("clay", (0.52, 0.22, 0.12, 1.0), roughness=0.8)


def leaves(count: int = 120) -> Scene:
    """A small tree whose leaves are alpha-masked cards, `count` of them: shadows must honour the mask."""
    foliage = Material(
        "leaves",
        base_color_texture=Texture(twig_texture(), "clamp", "clamp"),
        alpha_cutoff=0.5,
        double_sided=True,
        roughness=0.6,
    )
    pot = shapes.lathe([(0.22, 0.0), (0.30, 0.40), (0.33, 0.40), (0.33, 0.47), (0.28, 0.47), (0.26, 0.42)], 48)
    nodes = [
        shapes.floor(20.0, SOIL),
        shapes.node(pot, CLAY, name="pot"),
        shapes.node(shapes.lathe([(0.055, 0.40), (0.040, 0.80), (0.030, 1.40), (0.0, 1.75)], 16), BARK, name="trunk"),
        Node(_crown(count, foliage), name="leaves"),
    ]
    for turn in range(0, 360, 72):
        reach = np.array([np.cos(np.radians(turn)), 0.0, np.sin(np.radians(turn))])
        foot, tip = (0.0, 0.95 + turn / 900.0, 0.0), 0.42 * reach + (0.0, 1.35 + turn / 900.0, 0.0)
        nodes.append(shapes.node(shapes.tube(foot, tip, 0.014, 8), BARK, name="branch"))
    light = rect_light((1.9, 3.6, 1.0), (-0.3, 0.6, -0.2), 0.5, 0.5, irradiance=6.0)
    camera = Camera((1.7, 2.3, 3.6), (-0.36, 0.84, -0.12), 40.0)
    return shapes.scene(nodes, light, camera, "leaves")


def twig_texture(size: int = 256) -> npt.NDArray[np.uint8]:
    """(size, size, 4) uint8 sRGB picture of a twig with nine leaves; alpha falls off over one texel at edges."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size  # row 0 is v = 0: the twig grows from v = 1 to v = 0
    texel = 1.0 / size
    color = np.broadcast_to(
        (52.0, 84.0, 30.0), (size, size, 3)
    ).copy()  # leaf green under the clear texels, against dark fringes
    alpha = np.clip(0.5 + (0.010 - np.abs(x - 0.5 - 0.015 * np.sin(9.0 * y))) / texel, 0, 1) * (y > 0.12)
    leaves = [(0.5, 0.22, 0.0, 0.22)]
    for k in range(4):
        along = 0.86 - 0.17 * k
        leaves += [(0.5, along, sign * (62.0 - 5.0 * k), 0.40 - 0.035 * k) for sign in (-1, 1)]
    for k, (x0, y0, angle, length) in enumerate(leaves):
        sin, cos = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        along = ((x - x0) * sin - (y - y0) * cos) / length
        across = ((x - x0) * cos + (y - y0) * sin) / length
        inside = np.clip(along, 0.0, 1.0)
        half_width = 0.95 * inside * (1.0 - inside) ** 0.8
        coverage = np.clip(0.5 + (half_width - np.abs(across)) * length / texel, 0.0, 1.0) * (
            (along > 0.0) & (along < 1.0)
        )
        vein = 0.75 + 0.25 * np.clip(np.abs(across) * length / (2.0 * texel), 0.0, 1.0)
        shade = np.array((58.0, 98.0, 30.0)) * (0.85 + 0.06 * (k % 5)) * vein[..., None]
        color = np.where(coverage[..., None] > 0.0, shade, color)
        alpha = np.maximum(alpha, coverage)
    return np.dstack([color, 255.0 * alpha]).round().clip(0, 255).astype(np.uint8)


def _crown(count: int, material: Material) -> Mesh:
    """`count` upright-ish square cards on a sphere around the branches, each pointing away from the trunk."""
    rng = np.random.default_rng(6)
    away = rng.normal(size=(count, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    foot = np.array([0.0, 1.5, 0.0]) + away * rng.uniform(0.15, 0.52, (count, 1)) * (1.0, 0.85, 1.0)
    grow = away + (0.0, 0.35, 0.0) + 0.5 * rng.normal(size=(count, 3))
    grow /= np.linalg.norm(grow, axis=1, keepdims=True)
    side = np.cross(grow, rng.normal(size=(count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    size = rng.uniform(0.26, 0.38, (count, 1))
    corners = [foot + size * (u * side + v * grow) for u, v in ((-0.5, 0.0), (0.5, 0.0), (0.5, 1.0), (-0.5, 1.0))]
    uv = np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
    texcoords = np.zeros((2, 4 * count, 2), np.float32)
    texcoords[0] = np.tile(uv, (count, 1))
    quad = np.arange(count)[:, None] * 4
    triangles = np.concatenate([quad + np.array(corner) for corner in ((0, 1, 2), (0, 2, 3))]).astype(np.uint32)
    normals = np.repeat(np.cross(side, grow), 4, axis=0)
    return Mesh(
        np.stack(corners, axis=1).reshape(-1, 3), triangles, normals, texcoords, material=material, name="leaves"
    )
