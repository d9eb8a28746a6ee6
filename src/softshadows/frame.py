"""What a renderer gives back: plain arrays, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from softshadows.image.files import save_frame
from softshadows.scene.lights import Light

Floats = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


@dataclass
class FrameStats:
    """What a frame cost.

    `gpu_ms` by pass; `cpu_ms` to prepare and encode it, without the driver's submit; `gpu_bytes` held; `number` counts
    the renderer's frames from 1; with `looser_fits` shadow maps may have served that were fitted for other cameras.
    """

    shadow_maps: int = 0
    lookups_per_pixel: float = 0.0
    gpu_ms: dict[str, float] = field(default_factory=dict)
    cpu_ms: float = 0.0
    gpu_bytes: int = 0
    submits: int = 0
    warnings: list[str] = field(default_factory=list)
    number: int = 0
    looser_fits: bool = False


@dataclass(eq=False)
class Frame:
    """A rendered frame, all arrays row 0 at the top.

    color (height, width, 3) float32 linear radiance; visibility (lights, height, width) float32, 1 = lit, 0 = umbra, 1
    where there is no surface; position, normal (height, width, 3) float32 world space, the normal geometric and facing
    the viewer; depth (height, width) float32 metres along the view axis, inf where there is no surface; surface
    (height, width) bool.
    """

    color: Floats
    visibility: Floats
    position: Floats
    normal: Floats
    depth: Floats
    surface: Bools
    lights: list[Light]
    stats: FrameStats

    @property
    def facing(self) -> Bools:
        """(lights, height, width) bool: all of the light before the surface, the surface before a one-sided light."""
        planes = [light.facing(self.position, self.normal) & self.surface for light in self.lights]
        return np.stack(planes) if planes else np.zeros((0, *self.surface.shape), bool)

    def save(self, path: str | Path) -> None:
        """Write a .png (display transformed), .exr or .npz (linear, every image by name); else raises OptionError."""
        save_frame(
            path,
            color=self.color,
            visibility=self.visibility,
            position=self.position,
            normal=self.normal,
            depth=self.depth,
            surface=self.surface,
            facing=self.facing,
        )


def frame_of(images: Mapping[str, npt.NDArray], lights: list[Light], stats: FrameStats) -> Frame:
    """The frame that was read back as color, position (view depth in w) and normal, (height, width, 4) float32, and
    visibility."""
    position = images["position"]
    surface = position[..., 3] > 0.0
    return Frame(
        color=np.ascontiguousarray(images["color"][..., :3]),
        visibility=images["visibility"],
        position=np.ascontiguousarray(position[..., :3]),
        normal=np.ascontiguousarray(images["normal"][..., :3]),
        depth=np.where(surface, position[..., 3], np.float32(np.inf)),
        surface=surface,
        lights=lights,
        stats=stats,
    )
