"""A shot: one TOML file, or a few command-line words, that say everything about a picture.

    scene = "../bike/bike.glb"      # a model file relative to this one, or a built-in scene's name
    size = [1024, 768]              # all keys but `scene` are optional
    ground = true                   # a plane under the lowest point
    [camera]
    position = [4.5, 2.5, 5.5]
    target = [0.4, -0.9, 0.0]
    vertical_fov = 40.0
    [[lights]]
    type = "rect"
    position = [2.5, 4.5, 3.0]
    target = [0.4, -0.8, 0.0]
    width = 1.5
    height = 1.5
    radiance = [40.0, 40.0, 40.0]
    [technique]
    name = "variable_penumbra"
    resolution = 512                # or preset = "paper"
    [technique.kernels]             # or kernels = "from_light"
    type = "from_light"
    taps = 25

Without a camera or lights the scene's own are used, and where it has none either, a view and a light are made to fit.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from softshadows.errors import SceneError
from softshadows.scene import builtin
from softshadows.scene.camera import Camera
from softshadows.scene.description import Table, camera_from, light_from, size_from
from softshadows.scene.framing import complete
from softshadows.scene.lights import Light
from softshadows.scene.load import load_scene
from softshadows.scene.model import Scene

DEFAULT_SIZE = (1024, 768)
LARGEST_FILE = 1 << 20
"""A shot of more bytes than this is not a shot."""

OnMissing = Literal["error", "warn"]


@dataclass(frozen=True)
class TechniqueChoice:
    """A technique by name and its options as written; who renders resolves and checks them.

    `preset` is among the options, and a choice with options of its own is a dict: `{"type": "from_light", "taps": 49}`.
    """

    name: str
    options: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Shot:
    """A scene with its lights, the camera, the picture's (width, height), and the technique if the shot names one.

    `notes` says in sentences what was not given and has been chosen.
    """

    name: str
    scene: Scene
    camera: Camera
    size: tuple[int, int] = DEFAULT_SIZE
    technique: TechniqueChoice | None = None
    notes: list[str] = field(default_factory=list)


def load_shot(path: str | Path, *, on_missing: OnMissing = "error") -> Shot:
    """The shot that the TOML file at `path` describes.

    Raises SceneError naming the file and the key, such as `lights[0].width`, for anything missing, unknown or illegal.
    """
    return open_shot(path, on_missing=on_missing, kind="shot")


def open_shot(
    source: str | Path,
    *,
    camera: Camera | None = None,
    lights: Sequence[Light] = (),
    ground: bool = False,
    size: tuple[int, int] | None = None,
    on_missing: OnMissing = "error",
    kind: Literal["any", "shot"] = "any",
) -> Shot:
    """A shot from a shot file, a built-in scene's name or a model file; arguments that are given replace what it says.

    `kind="shot"` reads any file as a shot; otherwise files ending in .toml are.
    """
    file = Path(source)
    table = Table({"scene": str(source)})
    folder = Path()
    if kind == "shot" or file.suffix.lower() == ".toml":
        table, folder = Table(_read_toml(file), file=file), file.parent
    table.allow_only(["scene", "size", "ground", "camera", "lights", "technique"], "a shot")
    table.require(["scene"], "a shot")

    shot_size = size_from(table) if "size" in table.values else DEFAULT_SIZE
    shot_camera = camera_from(table.subtable("camera")) if "camera" in table.values else None
    shot_lights = [light_from(light) for light in table.subtables("lights")] if "lights" in table.values else []
    technique = _technique_from(table.subtable("technique")) if "technique" in table.values else None
    wants_ground = table.switch("ground") or ground

    scene = _scene_from(table, folder, on_missing)
    scene.camera = camera or shot_camera or scene.camera
    scene.lights = list(lights) or shot_lights or scene.lights
    if wants_ground:
        scene.add_ground()
    width, height = size or shot_size
    notes = [*scene.warnings, *complete(scene, aspect=width / height)]
    assert scene.camera is not None  # `complete` gave it one
    return Shot(file.stem, scene, scene.camera, (width, height), technique, notes)


def _read_toml(file: Path) -> dict[str, Any]:
    try:
        with file.open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(f"cannot be read: {reason}", code="FILE_UNREADABLE", file=file) from error
    if len(data) > LARGEST_FILE:
        raise SceneError("is larger than a megabyte, so it is no shot", code="FILE_TOO_BIG", file=file)
    try:
        return tomllib.loads(data.decode())
    except (ValueError, RecursionError) as error:
        raise SceneError(f"is not valid TOML: {error}", code="TOML_INVALID", file=file) from error


def _technique_from(table: Table) -> TechniqueChoice:
    table.require(["name"], "a technique")
    options: dict[str, Any] = {}
    for key, value in table.values.items():
        if isinstance(value, dict) and value:
            nested = table.subtable(key)
            options[key] = {inner: _plain(nested, inner) for inner in nested.values}
        elif key != "name":
            options[key] = _plain(table, key)
    return TechniqueChoice(table.text("name"), options)


def _plain(table: Table, key: str) -> Any:
    value = table.values[key]
    items = tuple(value) if isinstance(value, list) else (value,)
    if not all(isinstance(item, str | bool | int | float) for item in items):
        table.fail(f"must be a text, a number, true, false or a list of them, got {value!r}", key)
    return items if isinstance(value, list) else value


def _scene_from(table: Table, folder: Path, on_missing: OnMissing) -> Scene:
    """The built-in scene or model file that `scene` names; an unknown name is answered with those that exist."""
    name = table.text("scene")
    if name in builtin.SCENES:
        return builtin.make(name)
    path = folder / name
    if not Path(name).suffix and not path.exists():
        table.fail(
            f"{name!r} is neither a file nor a built-in scene; built in are {', '.join(builtin.SCENES)}",
            "scene",
            "SCENE_UNKNOWN",
        )
    return load_scene(path, on_missing=on_missing)
