"""Scene files to Scene: one module per format. `load_scene` chooses by the file's suffix."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from softshadows.errors import OptionError, SceneError
from softshadows.scene.load.gltf import load_gltf
from softshadows.scene.load.obj import load_obj
from softshadows.scene.load.trimesh_formats import load_ply, load_stl
from softshadows.scene.model import Scene

LOADERS: dict[str, Callable[[Path, str], Scene]] = {
    ".glb": load_gltf,
    ".gltf": load_gltf,
    ".obj": load_obj,
    ".ply": load_ply,
    ".stl": load_stl,
}


def load_scene(path: str | os.PathLike[str], *, on_missing: Literal["error", "warn"] = "error") -> Scene:
    """Read the scene file `path`: glTF 2.0 (.gltf, .glb), OBJ, PLY or STL.

    The file is not trusted: it cannot name files outside its folder, sizes are checked before memory is taken, and
    whatever is wrong with it raises SceneError, which names the fault (`code`) and its place (`file`, `pointer`). An
    image that is missing or corrupt is such a fault, unless `on_missing="warn"`: then its texture is left out and
    `scene.warnings` says so. `scene.warnings` also names what the file holds and softshadows ignores.

    Conventions: units are taken as metres, y up. OBJ, PLY and STL say nothing of sides: their materials are
    double-sided.
    """
    if on_missing not in ("error", "warn"):
        raise OptionError(f"on_missing must be 'error' or 'warn', got {on_missing!r}")
    file = Path(path)
    loader = LOADERS.get(file.suffix.lower())
    if loader is None:
        message = f"suffix {file.suffix!r} is not supported: expected one of {', '.join(LOADERS)}"
        raise SceneError(message, code="FORMAT_UNSUPPORTED", file=file)
    try:
        return loader(file, on_missing)
    except SceneError as error:
        if error.file is not None:
            raise
        raise SceneError(error.message, code=error.code, file=file, pointer=error.pointer) from error
    except MemoryError:
        raise SceneError("there is not enough memory for this file", code="FILE_TOO_BIG", file=file) from None
    except Exception as error:  # a fault of ours, but the promise to callers stands; tests look for this code
        raise SceneError(f"the reader failed: {error!r}", code="READER_FAILED", file=file) from error
