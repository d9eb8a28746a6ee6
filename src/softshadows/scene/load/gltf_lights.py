"""Lights and cameras of glTF nodes.

Photometric numbers are taken as radiometric ones: candela (point, spot) become W/sr, lux (directional) W/m² and nits
(area) W/(m² sr), each number × colour. `EXT_lights_area` is a draft: rectangles and disks, one-sided along −z, sized
by the node's largest scale.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from softshadows.errors import SceneError
from softshadows.scene.camera import Camera
from softshadows.scene.lights import DirectionalLight, DiskLight, Light, PointLight, RectLight, SpotLight
from softshadows.scene.load.checked_json import Item
from softshadows.scene.load.gltf_container import Asset
from softshadows.scene.vectors import Vector

T = TypeVar("T")

PUNCTUAL, AREA = "KHR_lights_punctual", "EXT_lights_area"
MAX_VERTICAL_FOV = math.radians(179.0)


class Frame:
    """Where a node's matrix puts its origin, and the unit directions of its −z and y axes."""

    def __init__(self, world: np.ndarray) -> None:
        self.position = _vector(world[:3, 3])
        self.scales = np.linalg.norm(world[:3, :3], axis=0)
        # Dividing by the largest number first keeps the length of very small axes from underflowing.
        self.forward, self.up = _unit(-world[:3, 2]), _unit(world[:3, 1])

    @property
    def target(self) -> Vector:
        """A point ahead, far enough that the difference keeps its direction in float64."""
        assert self.forward is not None
        distance = max(1.0, 1e-3 * max(map(abs, self.position)))
        return _vector(np.asarray(self.position) + distance * self.forward)

    @property
    def directed(self) -> bool:
        """False where the node is scaled to zero along z or y, so that it points nowhere."""
        return self.forward is not None and self.up is not None


def _vector(values: np.ndarray) -> Vector:
    return (float(values[0]), float(values[1]), float(values[2]))


def _unit(axis: np.ndarray) -> np.ndarray | None:
    largest = np.abs(axis).max()
    if not largest > 0.0:
        return None
    axis = axis / largest
    return axis / np.linalg.norm(axis)


class LightsAndCameras:
    """Reads the lights and cameras that hang on nodes."""

    def __init__(self, asset: Asset) -> None:
        self.asset = asset
        self.lights = {name: _definitions(asset.root, name) for name in (PUNCTUAL, AREA)}
        self.cameras = asset.root.objects("cameras")

    def lights_of(self, node: Item, world: np.ndarray) -> list[Light]:
        """The lights that `node` places."""
        found = []
        for name, definitions in self.lights.items():
            reference = node.extension(name)
            if reference is None:
                continue
            definition = definitions[reference.index("light", len(definitions), "light")]
            light = self._placed(definition, node, world, _punctual if name == PUNCTUAL else _area)
            if light is not None:
                found.append(light)
        return found

    def camera_of(self, node: Item, world: np.ndarray) -> Camera | None:
        """The perspective camera that `node` places, if any."""
        if "camera" not in node:
            return None
        definition = self.cameras[node.index("camera", len(self.cameras), "camera")]
        if definition.string("type", among=("perspective", "orthographic")) == "orthographic":
            self.asset.warn("orthographic cameras are skipped")
            return None
        return self._placed(definition, node, world, _camera)

    def _placed(self, definition: Item, node: Item, world: np.ndarray, make: Callable[[Item, Frame], T]) -> T | None:
        frame = Frame(world)
        if not frame.directed:
            self.asset.warn(f"node {node.string('name', '')!r}: a light or camera on a node scaled to zero is skipped")
            return None
        try:
            return make(definition, frame)
        except SceneError as error:
            if error.file is not None:
                raise
            raise definition.error(error.code or "VALUE_NOT_IN_RANGE", error.message) from None


def _definitions(root: Item, name: str) -> list[Item]:
    extension = root.extension(name)
    return [] if extension is None else extension.objects("lights")


def _emission(item: Item, default_intensity: float) -> Vector:
    intensity = item.number("intensity", default_intensity, low=0.0)
    red, green, blue = item.numbers("color", 3, (1.0, 1.0, 1.0), low=0.0)
    return (intensity * red, intensity * green, intensity * blue)


def _punctual(item: Item, frame: Frame) -> Light:
    kind = item.string("type", among=("point", "spot", "directional"))
    emission = _emission(item, 1.0)
    if kind == "point":
        return PointLight(frame.position, emission)
    if kind == "directional":
        assert frame.forward is not None
        return DirectionalLight(_vector(frame.forward), emission)
    cone = item.required_object("spot")
    outer = cone.number("outerConeAngle", math.pi / 4.0, low=0.0, high=math.pi / 2.0)
    inner = cone.number("innerConeAngle", 0.0, low=0.0, high=math.pi / 2.0)
    if inner >= outer:
        message = "the inner cone angle must be less than the outer one"
        raise cone.error("KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", message)
    return SpotLight(frame.position, frame.target, emission, math.degrees(inner), math.degrees(outer))


def _area(item: Item, frame: Frame) -> Light:
    kind = item.string("type", among=("rect", "disk"))
    radiance = _emission(item, 1000.0)
    size = item.number("size", 1.0, low=0.0) * float(frame.scales.max())
    if kind == "disk":
        return DiskLight(frame.position, frame.target, size / 2.0, radiance)
    shape = item.object("rect")
    aspect = 1.0 if shape is None else shape.number("aspect", 1.0, low=0.0)
    assert frame.up is not None
    return RectLight(frame.position, frame.target, size * aspect, size, radiance, up=_vector(frame.up))


def _camera(item: Item, frame: Frame) -> Camera:
    lens = item.required_object("perspective")
    near = lens.number("znear", low=0.0)
    if "zfar" in lens and lens.number("zfar") <= near:
        raise lens.error("CAMERA_ZFAR_LEQUAL_ZNEAR", "zfar must be greater than znear", "zfar")
    fov = math.degrees(lens.number("yfov", low=0.0, high=MAX_VERTICAL_FOV))
    assert frame.up is not None
    return Camera(frame.position, frame.target, fov, up=_vector(frame.up))
