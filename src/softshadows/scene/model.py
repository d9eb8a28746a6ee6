"""The scene: nodes that place meshes, materials, lights, cameras. Plain numpy data, no GPU."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from softshadows.errors import SceneError
from softshadows.scene.camera import Camera
from softshadows.scene.lights import Light

Wrap = Literal["repeat", "mirror", "clamp"]


@dataclass(eq=False)
class Texture:
    """An image and how it is read.

    `pixels` (height, width, 4) uint8, row 0 at v = 0, colours in sRGB where the material slot is a colour. `transform`
    (2, 3) float maps (u, v, 1) to the coordinates that are looked up (KHR_texture_transform). `texcoord` is the set, 0
    or 1.
    """

    pixels: npt.NDArray[np.uint8]
    wrap_u: Wrap = "repeat"
    wrap_v: Wrap = "repeat"
    nearest: bool = False
    transform: npt.NDArray[np.float32] = field(default_factory=lambda: np.eye(2, 3, dtype=np.float32))
    texcoord: int = 0
    name: str = ""


@dataclass(eq=False)
class Material:
    """Metallic-roughness material of glTF 2.0. Colours are linear; textures multiply their factors.

    `alpha_cutoff` None means opaque; otherwise points whose alpha (factor × texture × vertex colour) is below it do not
    exist, for the camera and for shadows alike. `emission` is radiance, RGB. Single-sided surfaces are not seen from
    behind but still cast shadows.
    """

    name: str = ""
    base_color: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    base_color_texture: Texture | None = None
    metallic: float = 0.0
    roughness: float = 0.7
    metallic_roughness_texture: Texture | None = None
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    emission_texture: Texture | None = None
    alpha_cutoff: float | None = None
    double_sided: bool = False


@dataclass(eq=False)
class Mesh:
    """Triangles with one material, in local space.

    positions (n, 3) float32; triangles (m, 3) uint32, counter-clockwise seen from the front; normals (n, 3) float32 or
    None (flat shading); texcoords (2, n, 2) float32 or None (two sets); colors (n, 4) float32 linear or None.
    """

    positions: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.uint32]
    normals: npt.NDArray[np.float32] | None = None
    texcoords: npt.NDArray[np.float32] | None = None
    colors: npt.NDArray[np.float32] | None = None
    material: Material = field(default_factory=Material)
    name: str = ""

    def __post_init__(self) -> None:
        self.positions = np.ascontiguousarray(self.positions, np.float32)
        triangles = np.asarray(self.triangles)
        count = len(self.positions)
        where = f"Mesh {self.name!r}"
        if self.positions.ndim != 2 or self.positions.shape[1] != 3:
            raise SceneError(f"{where}: positions must be (n, 3), got {self.positions.shape}", code="MESH_SHAPE")
        if triangles.ndim != 2 or triangles.shape[1] != 3:
            raise SceneError(f"{where}: triangles must be (m, 3), got {triangles.shape}", code="MESH_SHAPE")
        if not np.isfinite(self.positions).all():
            raise SceneError(f"{where}: positions must be finite", code="ACCESSOR_INVALID_FLOAT")
        if triangles.size and (triangles.min() < 0 or triangles.max() >= count):
            raise SceneError(f"{where}: triangles name vertices outside 0..{count - 1}", code="ACCESSOR_INDEX_OOB")
        self.triangles = np.ascontiguousarray(triangles, np.uint32)
        for name, shape in (("normals", (count, 3)), ("texcoords", (2, count, 2)), ("colors", (count, 4))):
            value = getattr(self, name)
            if value is None:
                continue
            value = np.ascontiguousarray(value, np.float32)
            if value.shape != shape:
                raise SceneError(f"{where}: {name} must be {shape}, got {value.shape}", code="MESH_SHAPE")
            if not np.isfinite(value).all():
                raise SceneError(f"{where}: {name} must be finite", code="ACCESSOR_INVALID_FLOAT")
            setattr(self, name, value)


@dataclass(eq=False)
class Node:
    """A mesh placed in the world by `transform`, a (4, 4) float64 column-vector matrix. Assign a new one to move it."""

    mesh: Mesh
    transform: npt.NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    name: str = ""


@dataclass(eq=False)
class Scene:
    """Nodes, lights and cameras. `camera` is the default view; `warnings` names what of the file is ignored."""

    nodes: list[Node] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    camera: Camera | None = None
    cameras: list[Camera] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    name: str = ""

    @property
    def triangle_count(self) -> int:
        return sum(len(node.mesh.triangles) for node in self.nodes)

    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) lowest and highest world coordinates of all vertices. Raises SceneError where there are none."""
        boxes = []
        for node in self.nodes:
            if len(node.mesh.positions):
                world = node.mesh.positions @ node.transform[:3, :3].T + node.transform[:3, 3]
                boxes.append((world.min(axis=0), world.max(axis=0)))
        if not boxes:
            raise SceneError("the scene has no vertices, so it has no bounds", code="SCENE_EMPTY")
        low, high = zip(*boxes, strict=True)
        return np.stack([np.min(low, axis=0), np.max(high, axis=0)])

    def add_ground(self, color: tuple[float, float, float] = (0.6, 0.6, 0.6)) -> Node:
        """Add a horizontal plane at the lowest point, eight diagonals of the bounding box wide, and return its node."""
        low, high = self.bounds()
        half = 4.0 * max(float(np.linalg.norm(high - low)), 1e-3)
        (x, _, z), y = (low + high) / 2.0, low[1]
        corners = [(x - half, y, z - half), (x - half, y, z + half), (x + half, y, z + half), (x + half, y, z - half)]
        mesh = Mesh(
            positions=np.array(corners, np.float32),
            triangles=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
            material=Material(name="ground", base_color=(*color, 1.0), roughness=0.9),
            name="ground",
        )
        node = Node(mesh, name="ground")
        self.nodes.append(node)
        return node
