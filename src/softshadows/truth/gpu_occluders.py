"""The scene's triangles as the GPU's rays see them: a second tracer, which shares no code with Embree.

Its tree, its edge tests and its alpha masks are those of `visibility="ray"` (passes/bvh, shaders/occluded.wgsl).
"""

from __future__ import annotations

import threading

import numpy as np

from softshadows.gpu.device import acquire
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.scene.geometry import Geometry
from softshadows.truth.tracer import NOT_ASKED, Array, Bools, Floats, Tracer
from softshadows.visibility.rays.cast import PACKET, Caster
from softshadows.visibility.rays.tree import Bvh


class GpuOccluders(Tracer):
    """Triangles that block light, asked on the GPU. Several threads may ask, one at a time. `seconds`: how long the
    GPU took for all answers so far.

    Raises DeviceError without an adapter, for scenes too large for it, and where the device ends a ray too early.
    """

    def __init__(self, geometry: Geometry) -> None:
        super().__init__(geometry)
        buffers = SceneBuffers(acquire(), geometry)
        self._caster, self._turn = Caster(buffers, Bvh(buffers)), threading.Lock()
        self.seconds = 0.0

    def blocked_from(self, start: Array, rays: Floats, t_max: Floats) -> Bools:
        count, width = t_max.shape
        packets = -(-width // PACKET)
        spare = packets * PACKET - width
        rays = np.pad(rays, ((0, 0), (0, spare), (0, 0))).reshape(-1, PACKET, 3)
        t_max = np.pad(t_max, ((0, 0), (0, spare)), constant_values=NOT_ASKED).reshape(-1, PACKET)
        origins = np.repeat(start.astype(np.float32), packets, axis=0)
        with self._turn:
            blocked = self._caster.blocked(origins, rays, t_max)
            self.seconds += self._caster.seconds
        return blocked.reshape(count, -1)[:, :width]
