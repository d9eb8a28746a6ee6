"""glTF 2.0 (.gltf, .glb) to Scene: a strict reader that refuses what it cannot show as the file means it.

Read: node hierarchies, triangles, strips and fans, all component types, sparse and quantized accessors,
metallic-roughness materials with textures, masks and emission, perspective cameras, punctual and area lights, Draco
and meshopt compression. Ignored with a line in `scene.warnings`: skins, animations, morph targets, points, lines,
blending, further extensions. Parts that nothing in the scene refers to are not read: real files carry broken leftovers.
"""

from __future__ import annotations

from pathlib import Path

from softshadows.scene.load.accessors import Accessors
from softshadows.scene.load.gltf_compression import DRACO
from softshadows.scene.load.gltf_container import MESHOPT, Asset, open_asset
from softshadows.scene.load.gltf_lights import AREA, PUNCTUAL, LightsAndCameras
from softshadows.scene.load.gltf_materials import Materials
from softshadows.scene.load.gltf_meshes import Meshes
from softshadows.scene.load.gltf_nodes import world_nodes
from softshadows.scene.model import Node, Scene

SUPPORTED_EXTENSIONS = frozenset(
    {
        AREA,
        DRACO,
        MESHOPT,
        PUNCTUAL,
        "EXT_texture_webp",
        "KHR_materials_emissive_strength",
        "KHR_materials_unlit",
        "KHR_mesh_quantization",
        "KHR_texture_transform",
    }
)

MAX_TRIANGLES = 2**25
"""Most triangles that all nodes together may place; flattened they take about 150 bytes each."""


def load_gltf(path: Path, on_missing: str) -> Scene:
    """Read a .gltf or .glb file. Raises SceneError."""
    asset = open_asset(path)
    _check_extensions(asset)
    accessors = Accessors.of(asset)
    meshes = Meshes.of(asset, accessors, Materials.of(asset, on_missing))
    placed = LightsAndCameras(asset)
    _warn_of_motion(asset)

    scene = Scene(name=path.stem)
    triangles = 0
    for node, world in world_nodes(asset.root):
        name = node.string("name", "")
        if "mesh" in node:
            for mesh in meshes.at(node.index("mesh", len(meshes), "mesh")):
                triangles += len(mesh.triangles)
                scene.nodes.append(Node(mesh, world.copy(), name))
        if triangles > MAX_TRIANGLES:
            raise node.error("FILE_TOO_BIG", f"the nodes place more than {MAX_TRIANGLES} triangles")
        scene.lights += placed.lights_of(node, world)
        camera = placed.camera_of(node, world)
        if camera is not None:
            scene.cameras.append(camera)
    if not triangles:
        asset.warn("the file's scene places no triangles")
    scene.camera = scene.cameras[0] if scene.cameras else None
    scene.warnings = asset.warnings
    return scene


def _check_extensions(asset: Asset) -> None:
    required = asset.root.strings("extensionsRequired")
    unsupported = sorted(set(required) - SUPPORTED_EXTENSIONS)
    if unsupported:
        message = f"the file cannot be shown without {', '.join(unsupported)[:200]}, which is not supported"
        raise asset.root.error("UNSUPPORTED_REQUIRED_EXTENSION", message, "extensionsRequired")
    for name in sorted(set(asset.root.strings("extensionsUsed")) - SUPPORTED_EXTENSIONS):
        asset.warn(f"extension {name[:60]} is ignored")


def _warn_of_motion(asset: Asset) -> None:
    if asset.root.objects("skins"):
        asset.warn("skins are ignored: meshes keep their bind pose")
    if asset.root.objects("animations"):
        asset.warn("animations are ignored")
