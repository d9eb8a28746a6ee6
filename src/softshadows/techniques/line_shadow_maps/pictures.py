"""Pictures of what soft shadow maps hold: visibility channels, and the skins that were drawn into them.

    renderer = ss.Renderer(scene, technique="line_shadow_maps")
    renderer.render(camera)
    maps = read_maps(renderer)
    image = channels_picture(maps, sample=0)

The GPU's textures are read between frames, so that a frame itself reads back nothing more. All pictures are float32 RGB
in 0..1, row 0 at the top. They show the light that took its turn last.

    channels_picture    a sample's map as the share of its segments that each texel sees      [Heidrich2000 Fig. 5]
    skins_picture       where a sample's skins begin: red towards the sample before, blue towards the one after
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from softshadows.errors import OptionError
from softshadows.gpu.layout import dtype
from softshadows.techniques.line_shadow_maps.line_shadow_maps import LineShadowMapsPass
from softshadows.techniques.line_shadow_maps.soft_maps import Control, Skin
from softshadows.visibility.maps.structs import FACES, ShadowView

Floats = npt.NDArray[np.float32]
TOWARDS_BEFORE, TOWARDS_AFTER = (1.0, 0.2, 0.1), (0.2, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class SoftMapContents:
    """What the maps of one light hold.

    samples: those in use, counted along the light. tile: texels along a sample's tile, of which `tiles_per_row` lie
    side by side. channels (atlas, atlas, 2) float32: the shares of the segments before and after, 2 where no skin lies.
    views, skins: structured arrays of ShadowView (FACES per sample) and Skin.
    """

    samples: list[int]
    tile: int
    tiles_per_row: int
    channels: Floats
    views: np.ndarray
    skins: np.ndarray

    def tile_of(self, image: np.ndarray, sample: int) -> np.ndarray:
        """The part of an atlas-sized image that belongs to a sample."""
        if sample not in self.samples:
            raise OptionError(f"sample {sample} has no map; choose one of {', '.join(map(str, self.samples))}")
        row, column = divmod(sample, self.tiles_per_row)
        return image[row * self.tile : (row + 1) * self.tile, column * self.tile : (column + 1) * self.tile]


def read_maps(renderer: Any) -> SoftMapContents:
    """What the last frame of a renderer with line_shadow_maps left in its maps. OptionError for another renderer."""
    at_work = getattr(renderer.passes, "technique", None)
    if not isinstance(at_work, LineShadowMapsPass) or not at_work.by_light:
        raise OptionError("pictures of soft shadow maps need a renderer that has rendered with line_shadow_maps")
    maps, _ = at_work.by_light[-1]
    queue, plan = maps.gpu.device.queue, maps.plan
    size = plan.atlas_size

    layout = {"bytes_per_row": 4 * size, "rows_per_image": size}
    texels = np.asarray(queue.read_texture({"texture": maps.channels}, layout, (size, size, 1))).view("<f2")
    control = np.asarray(queue.read_buffer(maps.control)).view(dtype(Control))[0]
    skins = np.asarray(queue.read_buffer(maps.skins)).view(dtype(Skin))
    return SoftMapContents(
        samples=[sample for sample in range(plan.samples) if int(control["samples"]) >> sample & 1],
        tile=plan.tile,
        tiles_per_row=plan.tiles_per_row,
        channels=texels.reshape(size, size, 2).astype(np.float32),
        views=np.asarray(queue.read_buffer(maps.maps.atlas.views)).view(dtype(ShadowView)),
        skins=skins[: min(int(control["skins"]), len(skins))],
    )


def channels_picture(contents: SoftMapContents, sample: int) -> Floats:
    """The mean of the sample's channels, each 0.5 where no skin lies: white sees all, as in the paper's figure 5."""
    shares = contents.tile_of(contents.channels, sample)
    is_first, is_last = sample == contents.samples[0], sample == contents.samples[-1]
    used = shares[..., 1:] if is_first else shares[..., :1] if is_last else shares
    grey = np.where(used > 1.0, 0.5, used).mean(axis=-1)
    return np.repeat(grey[..., None], 3, axis=2).astype(np.float32)


def skins_picture(contents: SoftMapContents, sample: int) -> Floats:
    """The sample's channels, dimmed, and on them the texels beside which its own skins begin."""
    picture = 0.4 * channels_picture(contents, sample)
    face, source, target = (contents.skins["ends"] >> shift & 0xFF for shift in (0, 8, 16))
    own = source == sample
    row, column = divmod(sample, contents.tiles_per_row)
    origin = contents.views["origin"][sample * FACES + face[own]] - np.array([column, row]) * contents.tile
    x = origin[:, 0] + (contents.skins["texel"][own] & 0xFFFF)
    y = origin[:, 1] + (contents.skins["texel"][own] >> 16)
    picture[y, x] = np.where((target[own] < sample)[:, None], TOWARDS_BEFORE, TOWARDS_AFTER)
    return picture
