"""Ray-traced visibility of area lights: the truth that techniques are compared with.

    visibility(p) = visible area of the light from p / total area of the light      (length for a line light)

estimated by one random point in each of many strata of equal area. A light point s is visible from a receiver p with
geometric normal n where dot(n, s − p) > 0, p lies before a one-sided light, and no triangle blocks the segment p s.
Every pixel draws its own points, so that errors show as noise instead of bands.

`segments` says where rays start and end. Who finds what blocks them is one of two: Embree, or the GPU's rays, so that
each is checked by the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.scene.geometry import flatten
from softshadows.scene.lights import Light
from softshadows.scene.model import Scene
from softshadows.truth.occluders import Occluders
from softshadows.truth.segments import Receivers, Surfaces, cells_of, stratified, to_points
from softshadows.truth.tracer import Array, Bools, Floats, Tracer

BACKENDS = ("embree", "gpu")
RAYS_PER_CHUNK = 1 << 16
"""Rays in flight per thread, about 10 MB of temporaries. The random numbers depend on it, and on no other size."""

MAX_SAMPLES = 1 << 16


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
    backend: str = "embree",
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
    backend: str = "embree",
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
    backend: str = "embree",
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
    backend         who traces the rays, the same for both: "embree", or "gpu", which is a second opinion, or the only
                    one where embreex cannot be installed.

    Raises SceneError for a scene whose transforms are not finite, OptionError for other arguments of the wrong kind,
    DeviceError where embreex is missing, and by the GPU's rays for scenes too large for it.
    """
    _check_integer(samples, "samples", 1, MAX_SAMPLES)
    _check_integer(seed, "seed", 0, 2**63)
    receivers = Receivers.of(frame)
    tracer = _tracer(scene, backend)
    shape = (len(scene.lights), receivers.count)
    share, error = np.ones(shape, np.float32), np.zeros(shape, np.float32)

    def estimate(index: int, cells: tuple[int, int], chunk: int, rows: slice) -> None:
        """Fills `rows` of one light; `chunk` gives them random numbers of their own."""
        light, part = scene.lights[index], receivers[rows]
        random = np.random.Generator(np.random.SFC64([seed, index, chunk]))
        seen = stratified(light, cells, part, tracer, random).visible(tracer)
        share[index, rows] = seen.mean(axis=1)
        error[index, rows] = _standard_error(seen, light)

    tasks = []
    for index, light in enumerate(scene.lights):
        cells = cells_of(light, samples)
        size = max(1, RAYS_PER_CHUNK // (cells[0] * cells[1]))
        for chunk, first in enumerate(range(0, receivers.count, size)):
            tasks.append((index, cells, chunk, slice(first, min(first + size, receivers.count))))
    _run_all(estimate, tasks, threads, progress)
    share_image = receivers.image(share, fill=1.0)
    return (share_image, receivers.image(error, fill=0.0)) if return_error else share_image


def visibility_from_points(
    scene: Scene,
    frame: Surfaces,
    points: npt.NDArray[Any],
    *,
    light: Light | None = None,
    threads: int | None = None,
    backend: str = "embree",
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
    receivers = Receivers.of(frame)
    tracer = _tracer(scene, backend)
    seen = np.ones((len(points), receivers.count), bool)

    def cast(rows: slice) -> None:
        seen[:, rows] = to_points(points, light, receivers[rows], tracer).visible(tracer).T

    size = max(1, RAYS_PER_CHUNK // max(1, len(points)))
    tasks = [(slice(first, min(first + size, receivers.count)),) for first in range(0, receivers.count, size)]
    _run_all(cast, tasks, threads, progress=False)
    return receivers.image(seen, fill=True)


def _tracer(scene: Scene, backend: str) -> Tracer:
    if backend not in BACKENDS:
        raise OptionError(f"backend must be one of {', '.join(BACKENDS)}, got {backend!r}")
    if backend == "embree":
        return Occluders(flatten(scene))
    from softshadows.truth.gpu_occluders import GpuOccluders  # starts the GPU's driver

    return GpuOccluders(flatten(scene))


def _standard_error(seen: Bools, light: Light) -> Array | float:
    """Standard error of the mean over cells, (n,), from successive differences (von Neumann's estimator).

    With one point per cell, E (a − b)² of two cells is the sum of their variances plus the square of the difference of
    their means: never too small, and close where neighbours are alike, which the binomial variance is not.
    """
    if not light.has_size:
        return 0.0
    count = seen.shape[1]
    if count == 1:
        return 0.5  # nothing to compare with: the most that one yes or no can err
    changes = np.count_nonzero(seen[:, 1:] != seen[:, :-1], axis=1)
    return np.sqrt(changes / (2.0 * (count - 1) * count))


def _run_all(work: Callable[..., None], tasks: list, threads: int | None, progress: bool) -> None:
    """Runs `work(*task)` for all tasks on a pool of threads; numpy and tracers let go of the interpreter meanwhile."""
    if threads is not None:
        _check_integer(threads, "threads", 1, 1024)
    with ThreadPoolExecutor(threads or processors()) as pool:
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


def processors() -> int:
    """Those that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


def _check_integer(value: object, name: str, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
        raise OptionError(f"{name} must be a whole number from {low} to {high}, got {value!r}")
