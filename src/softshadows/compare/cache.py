"""Measurements kept on disk while a comparison runs, so that an interrupted one goes on where it was.

A measurement is one file, named by what it depends on: the scene's content, camera, lights, picture size, technique
and options, rays, timed frames, profile, the adapter and the processor, and the package's own code. Another value of
any of them is another file, so a file that is found can be used as it is.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import softshadows
from softshadows.compare.environment import cpu_name
from softshadows.compare.interleaved import Timing
from softshadows.compare.measure import Truth
from softshadows.compare.results import write_bytes
from softshadows.frame import FrameStats
from softshadows.gpu.device import describe
from softshadows.scene.model import Scene
from softshadows.scene.shot import Shot
from softshadows.techniques import Technique

CODE, BESIDE = ("*.py", "*.wgsl", "*.npy"), "page"
"""Files of the package that figures depend on, and the folder that only shows them."""


@dataclasses.dataclass(frozen=True, eq=False)
class CachedFrame:
    """What is measured of a technique's frames: visibility (lights, height, width) float32, cost, and times by name."""

    visibility: npt.NDArray[np.float32]
    stats: FrameStats
    times: dict[str, Timing]


class MeasurementCache:
    """The measurements in a folder. With `fresh` those that are there are not used, but written anew."""

    def __init__(self, folder: Path, *, fresh: bool = False) -> None:
        self._folder, self._fresh = folder, fresh
        self._used: set[Path] = set()
        self._scenes: dict[int, tuple[Scene, str]] = {}

    def truth(self, shot: Shot, samples: int) -> Truth | None:
        """The truth of a shot, if it is there."""
        found = self._read(self._path("truth", shot, samples))
        return Truth(found[0], **found[1]) if found is not None else None

    def keep_truth(self, shot: Shot, samples: int, truth: Truth) -> None:
        about = {"standard_error": truth.standard_error, "seconds": truth.seconds}
        self._write(self._path("truth", shot, samples), truth.visibility, about)

    def frame(self, shot: Shot, technique: Technique, repeats: int, profile: str) -> CachedFrame | None:
        """A technique's measured frame, if it is there."""
        found = self._read(self._path(technique.name, shot, technique, repeats, profile))
        if found is None:
            return None
        times = {name: Timing(**timing) for name, timing in found[1]["times"].items()}
        return CachedFrame(found[0], FrameStats(**found[1]["stats"]), times)

    def keep_frame(self, shot: Shot, technique: Technique, repeats: int, profile: str, frame: CachedFrame) -> None:
        times = {name: dataclasses.asdict(timing) for name, timing in frame.times.items()}
        about = {"stats": dataclasses.asdict(frame.stats), "times": times}
        self._write(self._path(technique.name, shot, technique, repeats, profile), frame.visibility, about)

    def forget_others(self) -> None:
        """Delete what has not been asked for: measurements of other scenes, options or versions."""
        for path in set(self._folder.glob("*.npz")) - self._used:
            path.unlink(missing_ok=True)

    def _path(self, name: str, shot: Shot, *depends_on: object) -> Path:
        subject = (self._geometry(shot.scene), shot.camera, shot.scene.lights, shot.size)
        path = self._folder / f"{name}-{digest((_machine(), subject, depends_on))[:24]}.npz"
        self._used.add(path)
        return path

    def _geometry(self, scene: Scene) -> str:
        """The digest of a scene without its lights. It does not change while it is compared, so it is read once."""
        if id(scene) not in self._scenes:
            self._scenes[id(scene)] = (scene, digest(scene.nodes))  # the scene too: its id stays its own
        return self._scenes[id(scene)][1]

    def _read(self, path: Path) -> tuple[npt.NDArray[np.float32], dict[str, Any]] | None:
        """None where the file is missing or damaged: then it is measured again, and replaced."""
        if self._fresh:
            return None
        try:
            with np.load(path, allow_pickle=False) as stored:
                return stored["visibility"], json.loads(str(stored["about"]))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None

    def _write(self, path: Path, visibility: npt.NDArray[np.float32], about: dict[str, Any]) -> None:
        stream = io.BytesIO()
        np.savez_compressed(stream, visibility=visibility, about=np.array(json.dumps(about)))
        write_bytes(stream.getvalue(), path)


def digest(value: object) -> str:
    """A hexadecimal name for plain data: dataclasses, lists, tuples, arrays, numbers, texts. Equal data, equal name."""
    return _digest(value, {}).hex()


def _digest(value: object, known: dict[int, bytes]) -> bytes:
    """`known` holds the digests of objects seen before, by id: a mesh that many nodes place is read once."""
    if id(value) in known:
        return known[id(value)]
    state = hashlib.blake2b(type(value).__name__.encode(), digest_size=32)
    if isinstance(value, np.ndarray):
        state.update(f"{value.dtype.str}{value.shape}".encode())
        state.update(np.ascontiguousarray(value).data)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            state.update(_digest(getattr(value, field.name), known))
        known[id(value)] = state.digest()
    elif isinstance(value, list | tuple):
        for item in value:
            state.update(_digest(item, known))
    else:
        state.update(repr(value).encode())
    return state.digest()


@cache
def _machine() -> str:
    """Where and by what is measured: adapter, processor, and the code itself."""
    package = Path(softshadows.__file__).parent
    state = hashlib.blake2b(f"{describe()}{cpu_name()}{np.__version__}".encode(), digest_size=16)
    for path in sorted(path for pattern in CODE for path in package.rglob(pattern) if path.parent.name != BESIDE):
        state.update(str(path.relative_to(package)).encode())
        state.update(path.read_bytes())
    return state.hexdigest()
