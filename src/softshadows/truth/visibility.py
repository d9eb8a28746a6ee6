"""Ray-traced visibility of area lights: the truth that techniques are compared with.

    visibility(p) = visible area of the light from p / total area of the light      (length for a line light)

estimated by one random point in each of many strata of equal area. A light point s is visible from a receiver p with
geometric normal n where dot(n, s − p) > 0, p lies before a one-sided light, and no triangle blocks the segment p s.
Every pixel draws its own points, so that errors show as noise instead of bands.

Rays start a few ULP off the receiver along n, and end as far before a flat light, so that neither a receiver shadows
itself nor a lamp's own luminous face its light (see `occluders.OFFSET`).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Any, Literal, Protocol, overload

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.scene.geometry import flatten
from softshadows.scene.lights import Light
from softshadows.scene.model import Scene
from softshadows.truth.occluders import Occluders

Array = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]

RAYS_PER_CHUNK = 1 << 16
"""Rays in flight per thread, about 10 MB of temporaries. The random numbers depend on it, and on no other size."""

MAX_SAMPLES = 1 << 16


class Surfaces(Protocol):
    """What a frame must show: see `visibility`."""

    @property
    def position(self) -> npt.NDArray[Any]: ...
    @property
    def normal(self) -> npt.NDArray[Any]: ...
    @property
    def surface(self) -> npt.NDArray[Any]: ...


@overload
def visibility(
    scene: Scene,
    frame: Surfaces,
    samples: int = 1024,
    *,
    seed: int = 0,
    progress: bool = False,
    return_error: Literal[False] = False,
    threads: int | None = None,
) -> Floats: ...
@overload
def visibility(
    scene: Scene,
    frame: Surfaces,
    samples: int = 1024,
    *,
    seed: int = 0,
    progress: bool = False,
    return_error: Literal[True],
    threads: int | None = None,
) -> tuple[Floats, Floats]: ...
def visibility(
    scene: Scene,
    frame: Surfaces,
    samples: int = 1024,
    *,
    seed: int = 0,
    progress: bool = False,
    return_error: bool = False,
    threads: int | None = None,
) -> Floats | tuple[Floats, Floats]:
    """The share of each light of `scene` visible from each pixel of `frame`: (lights, height, width) float32, 0..1.

    frame           position (h, w, 3) and geometric unit normal (h, w, 3) facing the viewer, world space;
                    surface (h, w) bool. Pixels without surface hold 1.
    samples         light points per pixel: at least so many, as a grid of equal cells with the light's proportions
                    (1024 on a square are 32 × 32, on a line 1024 × 1). A light without size takes one, its centre.
    seed            other seeds give other noise; equal arguments give equal bits, whatever the number of threads.
    progress        shows a bar on the terminal.
    return_error    also return the standard error, (lights, height, width) float32. It comes from the differences of
                    neighbouring cells and errs upwards by a factor of one to two; it is 0 where all points agree, and
                    then up to about 3/samples can hide there.
    threads         how many to use; None for one per processor this process may run on.

    Raises SceneError for a scene whose transforms are not finite, OptionError for other arguments of the wrong kind,
    DeviceError where embreex is missing.
    """
    _check_integer(samples, "samples", 1, MAX_SAMPLES)
    _check_integer(seed, "seed", 0, 2**63)
    receivers = _receivers(frame)
    occluders = Occluders(flatten(scene))
    shape = (len(scene.lights), receivers.count)
    share, error = np.ones(shape, np.float32), np.zeros(shape, np.float32)

    def estimate(index: int, grid: tuple[int, int], chunk: int, rows: slice) -> None:
        """Fills `rows` of one light; `chunk` gives them random numbers of their own."""
        light, part = scene.lights[index], receivers[rows]
        random = np.random.Generator(np.random.SFC64([seed, index, chunk]))
        seen = _visible(occluders, light, part, _rays(light, grid, part, occluders, random))
        share[index, rows] = seen.mean(axis=1)
        error[index, rows] = _standard_error(seen, light)

    tasks = []
    for index, light in enumerate(scene.lights):
        grid = _grid(light, samples)
        size = max(1, RAYS_PER_CHUNK // (grid[0] * grid[1]))
        for chunk, first in enumerate(range(0, receivers.count, size)):
            tasks.append((index, grid, chunk, slice(first, min(first + size, receivers.count))))
    _run_all(estimate, tasks, threads, progress)
    share_image = receivers.image(share, fill=1.0)
    return (share_image, receivers.image(error, fill=0.0)) if return_error else share_image


def visibility_from_points(
    scene: Scene, frame: Surfaces, points: npt.NDArray[Any], *, light: Light | None = None, threads: int | None = None
) -> Bools:
    """Which of `points` (n, 3), world space, are visible from each pixel of `frame`: (n, height, width) bool.

    The ray-traced twin of n exact shadow maps: the mean over the sample points of a technique is what it would show if
    its maps were perfect, so its distance to `visibility` is the error of light sampling alone. `light`, where given,
    is the light the points lie on: a one-sided one is dark from behind. Pixels without surface hold True. Errors as
    `visibility`.
    """
    points = np.asarray(points)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise OptionError(f"points must be finite and of shape (n, 3), got {points.shape}")
    receivers = _receivers(frame)
    occluders = Occluders(flatten(scene))
    seen = np.ones((len(points), receivers.count), bool)

    def cast(rows: slice) -> None:
        part = receivers[rows]
        rays = (points - _start(part, occluders)[:, None, :]).astype(np.float32)
        seen[:, rows] = _visible(occluders, light, part, rays).T

    size = max(1, RAYS_PER_CHUNK // max(1, len(points)))
    tasks = [(slice(first, min(first + size, receivers.count)),) for first in range(0, receivers.count, size)]
    _run_all(cast, tasks, threads, progress=False)
    return receivers.image(seen, fill=True)


@dataclass(frozen=True)
class _Receivers:
    """The pixels that show a surface: position and normal (n, 3) float64, world space, and their place in the image."""

    position: Array
    normal: Array
    surface: Bools

    @property
    def count(self) -> int:
        return len(self.position)

    def __getitem__(self, rows: slice) -> _Receivers:
        return _Receivers(self.position[rows], self.normal[rows], self.surface)

    def image(self, values: npt.NDArray[Any], fill: float) -> npt.NDArray[Any]:
        """`values` (layers, n) as (layers, height, width), with `fill` where there is no surface."""
        result = np.full((len(values), *self.surface.shape), fill, values.dtype)
        result[:, self.surface] = values
        return result


def _receivers(frame: Surfaces) -> _Receivers:
    position, normal, surface = (np.asarray(getattr(frame, name)) for name in ("position", "normal", "surface"))
    if surface.ndim != 2 or surface.dtype != np.bool_:
        raise OptionError(f"frame.surface must be (height, width) bool, got {surface.shape} {surface.dtype}")
    for name, values in (("position", position), ("normal", normal)):
        if values.shape != (*surface.shape, 3) or not np.issubdtype(values.dtype, np.floating):
            raise OptionError(f"frame.{name} must be {(*surface.shape, 3)} float32, got {values.shape} {values.dtype}")
    position, normal = position[surface].astype(np.float64), normal[surface].astype(np.float64)
    if not np.isfinite(position).all():
        raise OptionError("frame.position must be finite wherever frame.surface is true")
    if not np.all(np.abs(np.linalg.norm(normal, axis=1) - 1.0) < 1e-3):  # also refuses NaN
        raise OptionError("frame.normal must have length 1 wherever frame.surface is true")
    return _Receivers(position, normal, surface)


def _grid(light: Light, samples: int) -> tuple[int, int]:
    """Cells along the light's two axes, at least `samples` in all, about as wide as high."""
    a, b = light.half_extent
    if a == 0.0 and b == 0.0:
        return (1, 1)
    if b == 0.0:
        return (samples, 1)
    if a == 0.0:
        return (1, samples)
    columns = int(np.clip(round(np.sqrt(samples * a / b)), 1, samples))
    return (columns, -(-samples // columns))


def _rays(
    light: Light, grid: tuple[int, int], receivers: _Receivers, occluders: Occluders, random: np.random.Generator
) -> Floats:
    """(n, k, 3) float32: from each receiver's `start` to one random point in each cell of the light, row by row."""
    start = _start(receivers, occluders)
    if light.kind == "directional":
        reach = np.linalg.norm(start - occluders.center, axis=1) + occluders.diagonal + 1.0  # past all triangles
        return (reach[:, None, None] * light.axes[2]).astype(np.float32)
    if light.half_extent == (0.0, 0.0):
        return (light.center - start)[:, None, :].astype(np.float32)

    columns, rows = grid
    s, t = random.random((2, receivers.count, rows, columns), np.float32)
    s = ((s + np.arange(columns, dtype=np.float32)) / np.float32(columns)).reshape(receivers.count, -1)
    t = ((t + np.arange(rows, dtype=np.float32)[:, None]) / np.float32(rows)).reshape(receivers.count, -1)
    if light.kind == "disk":
        return (light.points(s, t) - start[:, None, :]).astype(np.float32)
    corner, right, top = light.points(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    rays = np.empty((*s.shape, 3), np.float32)
    for axis in range(3):  # rectangles and lines are affine in (s, t); three long loops beat many of length three
        rays[..., axis] = (
            np.float32(right[axis] - corner[axis]) * s
            + np.float32(top[axis] - corner[axis]) * t
            + (corner[axis] - start[:, axis, None]).astype(np.float32)
        )
    return rays


def _start(receivers: _Receivers, occluders: Occluders) -> Array:
    """(n, 3) float64: where rays leave, clear of the surface."""
    return receivers.position + occluders.offset(receivers.position)[:, None] * receivers.normal


def _visible(occluders: Occluders, light: Light | None, receivers: _Receivers, rays: Floats) -> Bools:
    """(n, k) bool: whether each receiver sees the light points that its rays (n, k, 3) lead to."""
    offset = occluders.offset(receivers.position)
    above = np.matmul(rays, receivers.normal[:, :, None].astype(np.float32))[..., 0]  # of the start's horizon
    visible = above > -offset[:, None]
    until = np.float32(1.0)
    if light is not None and light.kind in ("rect", "disk"):
        height = (receivers.position - light.center) @ -light.axes[2]  # before the light's plane
        if light.one_sided:
            visible &= height[:, None] > 0.0
        until = 1.0 - occluders.offset(light.center) / np.maximum(np.abs(height), 1e-30)[:, None]
    elif light is None or light.kind != "directional":
        until = 1.0 - offset[:, None] / np.maximum(np.linalg.norm(rays, axis=2), 1e-30)

    start = np.broadcast_to(_start(receivers, occluders)[:, None, :], rays.shape)
    until = np.broadcast_to(until, visible.shape)
    if visible.all():
        return ~occluders.blocked_along(start, rays, until)
    visible[visible] = ~occluders.blocked_along(start[visible], rays[visible], until[visible])
    return visible


def _standard_error(seen: Bools, light: Light) -> Array | float:
    """Standard error of the mean over cells, (n,), from successive differences (von Neumann's estimator).

    With one point per cell, E (a − b)² of two cells is the sum of their variances plus the square of the difference of
    their means: never too small, and close where neighbours are alike, which the binomial variance is not.
    """
    if light.half_extent == (0.0, 0.0):
        return 0.0
    count = seen.shape[1]
    if count == 1:
        return 0.5  # nothing to compare with: the most that one yes or no can err
    changes = np.count_nonzero(seen[:, 1:] != seen[:, :-1], axis=1)
    return np.sqrt(changes / (2.0 * (count - 1) * count))


def _run_all(work: Callable[..., None], tasks: list, threads: int | None, progress: bool) -> None:
    """Runs `work(*task)` for all tasks on a pool of threads; numpy and Embree let go of the interpreter meanwhile."""
    if threads is not None:
        _check_integer(threads, "threads", 1, 1024)
    with ThreadPoolExecutor(threads or _processors()) as pool:
        pending = [pool.submit(work, *task) for task in tasks]
        try:
            for future in _tracked(pending, progress):
                future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _tracked(pending: list, progress: bool) -> Any:
    if not progress:
        return as_completed(pending)
    from rich.progress import track

    return track(as_completed(pending), description="ray-traced truth", total=len(pending))


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


def _check_integer(value: object, name: str, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
        raise OptionError(f"{name} must be a whole number from {low} to {high}, got {value!r}")
