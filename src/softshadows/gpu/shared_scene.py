"""A scene's copy on the device, one for all who draw it: uploaded once, patched when nodes have moved, counted."""

from __future__ import annotations

import numpy as np

from softshadows.gpu.device import Gpu
from softshadows.gpu.scene_buffers import SceneBuffers
from softshadows.scene.geometry import flatten
from softshadows.scene.model import Mesh, Scene

Placement = tuple[tuple[Mesh, bytes], ...]
"""Which mesh is where, node by node: the mesh, and its transform's bytes."""


class SharedScene:
    """The SceneBuffers of one scene on one device, and of the tree that hangs on them. See `open_scene`.

    Between frames the nodes may move: whoever draws asks `update` first, with the device's lock held until the frame is
    submitted, so that no other frame's placement comes between.
    """

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        self._gpu, self.scene = gpu.owner(), scene
        self._buffers: SceneBuffers | None = None
        self._placement: Placement = ()
        self.users = 0

    def update(self) -> SceneBuffers:
        """The buffers, brought up to date: others than before where nodes have come, gone or got other meshes.

        Raises SceneError for a scene that cannot be used, DeviceError where the device cannot hold it.
        """
        placement = _placement(self.scene)
        if self._buffers is not None and placement == self._placement:
            return self._buffers
        geometry = flatten(self.scene)
        if self._buffers is not None and [mesh for mesh, _ in placement] == [mesh for mesh, _ in self._placement]:
            self._buffers.move(geometry)
        else:
            self.forget()
            self._buffers = SceneBuffers(self._gpu, geometry)
        self._placement = placement
        return self._buffers

    def forget(self) -> None:
        """Release the buffers: the next `update` uploads the scene anew."""
        with self._gpu.lock:
            self._buffers = None
            self._gpu.release()

    def close(self) -> None:
        """Say goodbye: with its last user a scene leaves the device."""
        with self._gpu.lock:
            self.users -= 1
            if self.users == 0:
                self.forget()
                del self._gpu.scenes[id(self.scene)]


def open_scene(gpu: Gpu, scene: Scene) -> SharedScene:
    """The scene's copy on this device, the same for all; whoever opens it closes it."""
    with gpu.lock:
        shared: SharedScene = gpu.scenes.setdefault(id(scene), SharedScene(gpu, scene))
        shared.users += 1
        return shared


def _placement(scene: Scene) -> Placement:
    return tuple((node.mesh, np.asarray(node.transform, np.float64).tobytes()) for node in scene.nodes)
