"""The scene's triangles as something to ask: is this segment blocked?

Embree in robust mode (edge tests that leave no gap between triangles which share an edge), two scenes: opaque
triangles, which only need a yes or no, and those with an alpha mask, whose hits are looked up and passed where the
surface does not exist. Everything is moved to the scene's middle first, so that rays lose no precision far from the
origin beyond what the coordinates themselves have lost.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.errors import DeviceError, OptionError
from softshadows.scene.geometry import Geometry
from softshadows.truth.alpha import exists
from softshadows.truth.tracer import NOT_ASKED, OFFSET, Array, Bools, Floats, Tracer


class Occluders(Tracer):
    """Triangles that block light. Safe to use from several threads, which run in parallel.

    Raises DeviceError where embreex is not installed.
    """

    def __init__(self, geometry: Geometry) -> None:
        super().__init__(geometry)
        local = (geometry.positions - self.center).astype(np.float32)
        self._opaque = _embree_scene(local, geometry.triangles[: geometry.opaque_count])
        self._masked = _embree_scene(local, geometry.triangles[geometry.opaque_count :])

    def blocked(self, start: npt.NDArray[Any], end: npt.NDArray[Any]) -> Bools:
        """Whether a triangle lies between `start` and `end`: both (..., 3), world space, broadcast; (...) bool.

        Nothing is offset here: a segment that starts or ends on a triangle may count as blocked by it. Raises
        OptionError for other shapes and for coordinates that are not finite.
        """
        start, end = _points(start, "start"), _points(end, "end")
        start, end = np.broadcast_arrays(start, end)
        return self.blocked_along(start, end - start.astype(np.float64))

    def blocked_along(self, start: npt.NDArray[Any], ray: npt.NDArray[Any], t_max: npt.ArrayLike = 1.0) -> Bools:
        """Whether a triangle lies between `start` and start + until · ray: (...) bool; errors as `blocked`.

        `start` and `ray` are (..., 3) of one shape, world space, metres, unlike `t_max` (...), a share of the ray.
        """
        start, ray = _points(start, "start"), _points(ray, "ray")
        if start.shape != ray.shape:
            raise OptionError(f"start and ray must have one shape, got {start.shape} and {ray.shape}")
        shape = ray.shape[:-1]
        origin = np.ascontiguousarray(start - self.center, np.float32).reshape(-1, 3)
        direction = np.ascontiguousarray(ray, np.float32).reshape(-1, 3)
        share = np.array(np.broadcast_to(t_max, shape), np.float32).reshape(-1)  # Embree wants to be able to write
        return self._blocked(origin, direction, share).reshape(shape)

    def blocked_from(self, start: Array, rays: Floats, t_max: Floats) -> Bools:
        starts = np.broadcast_to(start[:, None, :], rays.shape)
        asked = t_max != NOT_ASKED
        if asked.all():
            return self.blocked_along(starts, rays, t_max)
        blocked = np.ones(t_max.shape, bool)
        blocked[asked] = self.blocked_along(starts[asked], rays[asked], t_max[asked])
        return blocked

    def _blocked(self, origin: Floats, direction: Floats, share: Floats) -> Bools:
        """Contiguous float32 arrays of one length, (n, 3), (n, 3) and (n,): Embree checks none of it."""
        blocked = np.zeros(len(origin), bool)
        if self._opaque is not None:
            blocked = self._opaque.run(origin, direction, share, query="OCCLUDED") >= 0
        if self._masked is not None:
            rest = np.flatnonzero(~blocked)
            blocked[rest] = self._blocked_by_masked(origin[rest], direction[rest], share[rest])
        return blocked

    def _blocked_by_masked(self, origin: Floats, direction: Floats, share: Floats) -> Bools:
        """Passes each ray through the surfaces that do not exist, until one does or the ray ends."""
        assert self._masked is not None
        blocked = np.zeros(len(origin), bool)
        length = np.linalg.norm(direction.astype(np.float64), axis=1)
        least_step = (
            OFFSET * self.extent / np.maximum(length, np.finfo(np.float64).tiny)
        )  # clears the plane just passed
        reached, step = np.zeros(len(origin)), least_step.copy()  # shares of the ray
        previous = np.full(len(origin), -1)
        active = np.arange(len(origin))
        while len(active):
            onward = direction[active]
            start = (origin[active] + reached[active, None] * onward).astype(np.float32)
            hit = self._masked.run(start, onward, (share[active] - reached[active]).astype(np.float32), output=1)

            found = hit["primID"] >= 0
            active, triangle = active[found], hit["primID"][found]
            solid = self._exists(triangle, hit["u"][found], hit["v"][found])
            blocked[active[solid]] = True

            # A ray that skims the plane it just passed may meet it again: ever longer steps end that.
            step[active] = np.where(triangle == previous[active], 2.0 * step[active], least_step[active])
            previous[active] = triangle
            reached[active] += hit["tfar"][found] + step[active]
            active = active[~solid & (reached[active] < share[active])]
        return blocked

    def _exists(self, triangle: npt.NDArray[np.int32], u: Floats, v: Floats) -> Bools:
        """Whether the masked triangles' surface exists at the barycentric coordinates (1 − u − v, u, v)."""
        geometry = self.geometry
        triangle = triangle + geometry.opaque_count
        weight = np.stack([1 - u - v, u, v], axis=1)
        corners = geometry.triangles[triangle]
        texcoords = np.einsum("nk,nkc->nc", weight, geometry.texcoords[corners])
        colors = np.einsum("nk,nkc->nc", weight, geometry.colors[corners])
        material_index = geometry.material_index[triangle]
        solid = np.zeros(len(triangle), bool)
        for index in np.unique(material_index):
            chosen = material_index == index
            solid[chosen] = exists(geometry.materials[index], texcoords[chosen], colors[chosen])
        return solid


def _points(values: npt.NDArray[Any], name: str) -> npt.NDArray[Any]:
    values = np.asarray(values)
    if values.shape[-1:] != (3,) or not np.isfinite(values).all():
        raise OptionError(f"{name} must be finite points of shape (..., 3), got shape {values.shape}")
    return values


def _embree_scene(positions: Floats, triangles: npt.NDArray[np.uint32]) -> Any:
    """A committed robust Embree scene, or None without triangles."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as error:
        raise DeviceError(
            "ray-traced truth needs embreex, which cannot be imported here: pip install embreex "
            "(wheels exist for x86-64 Linux, Windows and macOS)"
        ) from error
    if not len(triangles):
        return None
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, np.ascontiguousarray(positions), np.ascontiguousarray(triangles, np.int32))
    ray = np.zeros((1, 3), np.float32)
    scene.run(ray, ray + 1, query="OCCLUDED")  # the first query builds the tree, which threads must not race for
    return scene
