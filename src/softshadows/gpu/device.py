"""The GPU: which adapter, which optional features, what its limits allow.

One device per process and profile, since adapters keep memory for every device ever made.
"""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal, TypeVar, get_args
from weakref import WeakSet

import numpy as np
import wgpu

from softshadows.errors import DeviceError, OptionError
from softshadows.gpu.budget import HARDWARE, SOFTWARE, Budget
from softshadows.gpu.layout import Struct, pack

OPTIONAL_FEATURES = {
    "clip-distances": "without it shadow maps are cached apart by a fragment shader, which draws the same more slowly",
    "timestamp-query": "without it frame.stats.gpu_ms is empty",
}
"""Features asked for where the adapter has them, with what happens without."""

PROFILES = ("full", "portable")
"""What a device may use: all that helps, or exactly what every WebGPU device has, browsers and phones included."""

DEFAULT_LIMITS: dict[str, int | None] = {
    "max-texture-dimension-1d": 8192,
    "max-texture-dimension-2d": 8192,
    "max-texture-dimension-3d": 2048,
    "max-texture-array-layers": 256,
    "max-bind-groups": 4,
    "max-bindings-per-bind-group": 1000,
    "max-dynamic-uniform-buffers-per-pipeline-layout": 8,
    "max-dynamic-storage-buffers-per-pipeline-layout": 4,
    "max-sampled-textures-per-shader-stage": 16,
    "max-samplers-per-shader-stage": 16,
    "max-storage-buffers-per-shader-stage": 8,
    "max-storage-textures-per-shader-stage": 4,
    "max-uniform-buffers-per-shader-stage": 12,
    "max-uniform-buffer-binding-size": 65536,
    "max-storage-buffer-binding-size": 134217728,
    "min-uniform-buffer-offset-alignment": 256,
    "min-storage-buffer-offset-alignment": 256,
    "max-vertex-buffers": 8,
    "max-buffer-size": 268435456,
    "max-vertex-attributes": 16,
    "max-vertex-buffer-array-stride": 2048,
    "max-inter-stage-shader-variables": 16,
    "max-color-attachments": 8,
    "max-color-attachment-bytes-per-sample": 32,
    "max-compute-workgroup-storage-size": 16384,
    "max-compute-invocations-per-workgroup": 256,
    "max-compute-workgroup-size-x": 256,
    "max-compute-workgroup-size-y": 256,
    "max-compute-workgroup-size-z": 64,
    "max-compute-workgroups-per-dimension": 65535,
}
"""WebGPU's defaults (specification, section 3.6.2), by wgpu-py's names."""

RAISED_LIMITS = ("max-texture-dimension-2d", "max-storage-buffer-binding-size", "max-buffer-size")
"""Limits that the full profile names as the adapter's own; wgpu-py then raises all others to the adapter's as well."""

Dependency = Literal["scene", "camera", "light", "samples", "constant", "frame"]
"""What written data depend on: nodes and meshes, the camera, lights, the points on them that are sampled, nothing that
changes, or how many frames came before, which only the read-back asks for."""

Owned = wgpu.GPUBuffer | wgpu.GPUTexture | wgpu.GPUQuerySet
OwnedT = TypeVar("OwnedT", bound=Owned)


@dataclass(frozen=True, eq=False)
class Gpu:
    """A device and what it may use. `fallbacks` names the optional features it lacks, with the consequence.

    `pipelines` holds the modules and pipelines made so far (program.py). Every function in `write_listeners` is called
    with the arguments of every `write`: how the writes of a frame are recorded. `scenes` holds the scenes on the device
    (shared_scene.py). Who prepares, encodes or submits a frame holds `lock`; waiting for its results needs no lock.
    """

    adapter: wgpu.GPUAdapter
    device: wgpu.GPUDevice
    features: frozenset[str]
    fallbacks: list[str] = field(default_factory=list)
    pipelines: dict[object, Any] = field(default_factory=dict)
    write_listeners: list[Callable[[wgpu.GPUBuffer, int, bytes | np.ndarray, Dependency], None]] = field(
        default_factory=list
    )
    scenes: dict[int, Any] = field(default_factory=dict)
    lock: threading.RLock = field(default_factory=threading.RLock)
    owned: WeakSet[Owned] | None = None

    def owner(self) -> Gpu:
        """The same device for somebody who owns what is made through it, until `release` destroys it all."""
        return replace(self, owned=WeakSet())

    def release(self) -> None:
        """Destroy the buffers, textures and query sets that were made through this owner."""
        assert self.owned is not None, "only an owner can release"
        for item in [*self.owned]:
            item.destroy()
        self.owned.clear()

    def destroy(self, item: Owned) -> None:
        """Destroy one of them before the others. What has been submitted may still use it."""
        if self.owned is not None:
            self.owned.discard(item)
        item.destroy()

    def _own(self, item: OwnedT) -> OwnedT:
        if self.owned is not None:
            self.owned.add(item)
        return item

    @property
    def is_cpu(self) -> bool:
        return self.adapter.info["adapter_type"].upper() == "CPU"

    @property
    def budget(self) -> Budget:
        """What one submit may hold."""
        return SOFTWARE if self.is_cpu else HARDWARE

    def limit(self, name: str) -> int:
        return int(self.device.limits[name])

    def check_texture(self, width: int, height: int, what: str) -> None:
        """DeviceError where a texture of this size cannot exist."""
        most = self.limit("max-texture-dimension-2d")
        if max(width, height) > most:
            raise DeviceError(
                f"{what} would be {width}×{height} texels; this adapter allows {most}×{most}. Lower the size."
            )

    def check_buffer(self, size: int, what: str) -> None:
        """DeviceError where a storage buffer of `size` bytes cannot be bound."""
        most = min(self.limit("max-storage-buffer-binding-size"), self.limit("max-buffer-size"))
        if size > most:
            raise DeviceError(
                f"{what} would take {size / 2**20:.0f} MiB; this adapter binds at most {most / 2**20:.0f} MiB at once. "
                "Lower the image size, the number of lights or the number of triangles."
            )

    def buffer(self, size: int, usage: int, what: str) -> wgpu.GPUBuffer:
        """A buffer of `size` bytes, all 0, that can also be copied from and to. DeviceError where it is too large."""
        self.check_buffer(size, what)
        usage |= wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST
        return self._own(self.device.create_buffer(label=what, size=size, usage=usage))

    def storage_buffer(self, size: int, what: str) -> wgpu.GPUBuffer:
        """A `buffer` for shaders to read and write."""
        return self.buffer(size, wgpu.BufferUsage.STORAGE, what)

    def uniform(self, value: Struct) -> wgpu.GPUBuffer:
        """A uniform buffer that holds `value`."""
        data = pack(value)
        buffer = self.buffer(len(data), wgpu.BufferUsage.UNIFORM, type(value).__name__)
        self.write(buffer, 0, data, what="constant")
        return buffer

    def texture(self, size: tuple[int, int], format: str, usage: int, what: str) -> wgpu.GPUTexture:
        """A 2-d texture of one layer and level. DeviceError where the adapter has none so large."""
        self.check_texture(*size, what)
        return self.layered_texture(size, 1, format, usage, what)

    def layered_texture(
        self, size: tuple[int, int], layers: int, format: str, usage: int, what: str
    ) -> wgpu.GPUTexture:
        """A 2-d texture of one level with so many layers."""
        extent = (*size, layers)
        return self._own(self.device.create_texture(label=what, size=extent, format=format, usage=usage))

    def staging_buffer(self, size: int, what: str) -> wgpu.GPUBuffer:
        """A buffer to copy into, and to map for reading."""
        usage = wgpu.BufferUsage.MAP_READ | wgpu.BufferUsage.COPY_DST
        return self._own(self.device.create_buffer(label=what, size=size, usage=usage))

    def timestamps(self, count: int) -> wgpu.GPUQuerySet:
        """So many timestamps for passes to write."""
        return self._own(self.device.create_query_set(type="timestamp", count=count))

    def bundle_encoder(self, depth_format: str) -> wgpu.GPURenderBundleEncoder:
        """For draws into depth alone, recorded once and replayed."""
        return self.device.create_render_bundle_encoder(color_formats=[], depth_stencil_format=depth_format)

    def write(self, buffer: wgpu.GPUBuffer, offset: int, data: bytes | np.ndarray, *, what: Dependency) -> None:
        """Write contiguous `data` into `buffer` from `offset` bytes on, before the next submit.

        `what` names all that the data depend on by its most changing part.
        """
        assert what in get_args(Dependency), f"nothing depends on {what!r}"
        for listener in self.write_listeners:
            listener(buffer, offset, data, what)
        self.device.queue.write_buffer(buffer, offset, data)

    def write_texture(self, texture: wgpu.GPUTexture, layer: int, data: np.ndarray) -> None:
        """Write a whole layer: (height, width, channels) texels, which belong to the scene or are constant."""
        height, width, _ = data.shape
        destination, layout = {"texture": texture, "origin": (0, 0, layer)}, {"bytes_per_row": data.nbytes // height}
        self.device.queue.write_texture(destination, data, layout, (width, height, 1))


def acquire(profile: str = "full") -> Gpu:
    """The process's device on the best adapter. Raises DeviceError where there is none, saying what to install.

    "portable": without optional features, and with exactly WebGPU's default limits. OptionError for other words.
    """
    if profile not in PROFILES:
        raise OptionError(f"profile must be one of {', '.join(PROFILES)}, got {profile!r}")
    return _device(profile)


@cache
def _device(profile: str) -> Gpu:
    if "XDG_RUNTIME_DIR" not in os.environ:  # the Vulkan loader prints an error line without it
        os.environ["XDG_RUNTIME_DIR"] = tempfile.gettempdir()
    try:
        adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError as error:
        raise DeviceError(
            "no WebGPU adapter was found. On Debian or Ubuntu without a GPU: apt-get install mesa-vulkan-drivers. "
            f"With a GPU: install its Vulkan driver. ({error})"
        ) from None
    is_portable = profile == "portable"
    features = frozenset(name for name in OPTIONAL_FEATURES if name in adapter.features and not is_portable)
    limits = DEFAULT_LIMITS if is_portable else {name: adapter.limits[name] for name in RAISED_LIMITS}
    with device_errors("the device could not be created"):
        device = adapter.request_device_sync(required_features=sorted(features), required_limits=dict(limits))
    fallbacks = [f"{name}: {effect}" for name, effect in OPTIONAL_FEATURES.items() if name not in features]
    return Gpu(adapter, device, features, fallbacks)


def describe() -> dict[str, object]:
    """Adapter, driver, the features in use and the limits that matter, as plain data for reports."""
    gpu = acquire()
    info = gpu.adapter.info
    return {
        "adapter": info["device"],
        "type": info["adapter_type"],
        "backend": info["backend_type"],
        "driver": info["description"],
        "features": sorted(gpu.features),
        "fallbacks": gpu.fallbacks,
        "limits": {name: gpu.limit(name) for name in RAISED_LIMITS},
    }


@contextmanager
def device_errors(doing: str) -> Iterator[None]:
    """Turn wgpu's errors into DeviceError."""
    try:
        yield
    except wgpu.GPUOutOfMemoryError as error:
        raise DeviceError(
            f"{doing}: the adapter ran out of memory. Lower size, resolution or the memory budget. ({error})"
        ) from None
    except wgpu.GPUError as error:
        raise DeviceError(f"{doing}: {error}") from None
