"""The farthest surface in each texel of a shadow atlas: says whether something lies behind the nearest."""

from __future__ import annotations

import wgpu

from softshadows.gpu.commands import Commands
from softshadows.gpu.device import Gpu
from softshadows.gpu.program import view_of
from softshadows.visibility.maps.shadow_maps import ShadowMaps


class LastLayer:
    """The maps' occluders drawn once more, into the same views, with the depth test turned round.

    `view` holds inverse depth like the atlas, 1 where there is nothing. For maps that are one chunk.
    """

    def __init__(self, gpu: Gpu, maps: ShadowMaps) -> None:
        assert maps.plan.chunks == 1, "every chunk would need its own turn"
        size = maps.plan.atlas_size
        self.bytes = 4 * size * size
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
        self.view = view_of(gpu.texture((size, size), "depth32float", usage, "the last layer"))
        self._draws = maps.record_draws(0, maps.draw_programs("less"), clears_views=False)

    def encode(self, commands: Commands) -> None:
        """After the maps' own draw, which has found the views."""
        attachment = {
            "view": self.view,
            "depth_load_op": "clear",
            "depth_store_op": "store",
            "depth_clear_value": 1.0,
        }
        with commands.draw("last_layer", color_attachments=[], depth_stencil_attachment=attachment) as draw:
            draw.execute_bundles([self._draws])
