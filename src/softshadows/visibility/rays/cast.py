"""Segments asked about outside of a frame, four from one point at a time: for truth, tests, and times of the walk."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from softshadows.errors import DeviceError
from softshadows.gpu.commands import Commands
from softshadows.gpu.compose import constant
from softshadows.gpu.program import Program
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.gpu.timing import PassTimer
from softshadows.visibility.rays.grid import groups_of
from softshadows.visibility.rays.tree import CUT_SHORT, Bvh

PACKET = 4
"""Segments from one point."""
AT_ONCE = 1 << 16
"""Packets of one submit, so that no driver's watchdog ends it."""
_CUT_SHORT_BIT = constant("visibility/rays/cast.wgsl", "CUT_SHORT")


class Caster:
    """Casts through the tree of one scene, and waits for answers. `seconds`: how long the last ones took to find."""

    def __init__(self, scene: SceneBuffers, tree: Bvh) -> None:
        self._gpu, self._tree, self._timer = scene.gpu, tree, PassTimer(scene.gpu)
        self._packets = self._gpu.storage_buffer(80 * AT_ONCE, "the packets of segments")
        self._blocked = self._gpu.storage_buffer(4 * AT_ONCE, "which segments are blocked")
        self._cast = Program(
            self._gpu,
            "visibility/rays/cast.wgsl",
            "cs_cast",
            {**tree.resources, "packets": self._packets, "blocked": self._blocked},
            stand_ins=tree.stand_ins,
        )
        self.seconds = 0.0

    def blocked(
        self, origins: npt.NDArray[np.float32], rays: npt.NDArray[np.float32], t_max: npt.ArrayLike = 1.0
    ) -> npt.NDArray[np.bool_]:
        """(n, 4): is the segment from origins (n, 3) along the share `t_max` of rays (n, 4, 3) blocked? World space.

        `t_max` is one for all, or (n, 4); where it is negative the answer is yes. Raises DeviceError where the
        device ended a walk too early.
        """
        self._update_tree()
        self.seconds = 0.0
        packets = np.zeros((len(origins), 5, 4), np.float32)
        packets[:, 0, :3] = origins
        packets[:, 1:4] = rays.transpose(0, 2, 1)
        packets[:, 4] = t_max
        bits = [self._some(packets[start : start + AT_ONCE]) for start in range(0, len(packets), AT_ONCE)]
        answers = np.concatenate([np.zeros(0, np.uint32), *bits])
        if (answers & _CUT_SHORT_BIT).any():
            raise DeviceError(CUT_SHORT)
        return (answers[:, None] >> np.arange(PACKET) & 1).astype(bool)

    def _some(self, packets: npt.NDArray[np.float32]) -> npt.NDArray[np.uint32]:
        self._gpu.write(self._packets, 0, packets, what="samples")
        commands = Commands(self._gpu, self._timer)
        with commands.compute("cast") as compute:
            self._cast.dispatch(compute, groups_of(len(packets)))
        started = time.perf_counter()
        commands.submit()
        answers = np.asarray(self._gpu.device.queue.read_buffer(self._blocked, 0, 4 * len(packets))).view(np.uint32)
        self.seconds += time.perf_counter() - started
        return answers

    def _update_tree(self) -> None:
        self._timer.begin_frame()
        commands = Commands(self._gpu, self._timer)
        self._tree.encode(commands)
        commands.submit()
