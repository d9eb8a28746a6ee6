"""Soft shadows from area and linear lights, in real time, on WebGPU, measured against ray-traced truth.

In a program:

    import softshadows as ss

    scene = ss.load_scene("model.glb")
    scene.lights = [ss.RectLight(position=(0, 4, 0), target=(0, 0, 0), width=1, height=1, radiance=(10, 10, 10))]
    frame = ss.render(scene, ss.Camera(position=(3, 2, 3), target=(0, 0, 0)))
    frame.save("picture.png")
"""

from importlib import import_module
from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from softshadows import metrics, techniques, truth
    from softshadows.errors import DeviceError, OptionError, SceneError, ShaderError, SoftShadowsError
    from softshadows.frame import Frame, FrameStats
    from softshadows.renderer import Renderer, render
    from softshadows.scene import builtin as scenes
    from softshadows.scene.camera import Camera
    from softshadows.scene.lights import (
        DirectionalLight,
        DiskLight,
        LineLight,
        PointLight,
        RectLight,
        SpotLight,
    )
    from softshadows.scene.load import load_scene
    from softshadows.scene.model import Material, Mesh, Node, Scene, Texture
    from softshadows.scene.shot import Shot, load_shot
    from softshadows.techniques.frame_passes import Images

__version__ = _version("softshadows")

_HOMES = {
    "softshadows.metrics": ("metrics",),
    "softshadows.techniques": ("techniques",),
    "softshadows.truth": ("truth",),
    "softshadows.errors": ("DeviceError", "OptionError", "SceneError", "ShaderError", "SoftShadowsError"),
    "softshadows.frame": ("Frame", "FrameStats"),
    "softshadows.renderer": ("Renderer", "render"),
    "softshadows.scene.builtin": ("scenes",),
    "softshadows.scene.camera": ("Camera",),
    "softshadows.scene.lights": (
        "DirectionalLight",
        "DiskLight",
        "LineLight",
        "PointLight",
        "RectLight",
        "SpotLight",
    ),
    "softshadows.scene.load": ("load_scene",),
    "softshadows.scene.model": ("Material", "Mesh", "Node", "Scene", "Texture"),
    "softshadows.scene.shot": ("Shot", "load_shot"),
    "softshadows.techniques.frame_passes": ("Images",),
}
"""Where the public names live; a module listed under its own name stands for itself."""

__all__ = [
    "Camera",
    "DeviceError",
    "DirectionalLight",
    "DiskLight",
    "Frame",
    "FrameStats",
    "Images",
    "LineLight",
    "Material",
    "Mesh",
    "Node",
    "OptionError",
    "PointLight",
    "RectLight",
    "Renderer",
    "Scene",
    "SceneError",
    "ShaderError",
    "Shot",
    "SoftShadowsError",
    "SpotLight",
    "Texture",
    "__version__",
    "load_scene",
    "load_shot",
    "metrics",
    "render",
    "scenes",
    "techniques",
    "truth",
]


def __getattr__(name: str) -> Any:
    """Imports a public name when first used, so that `softshadows --help` waits for neither numpy nor wgpu."""
    for home, names in _HOMES.items():
        if name in names:
            module = import_module(home)
            value = getattr(module, name, module)
            globals()[name] = value
            return value
    raise AttributeError(f"module 'softshadows' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
