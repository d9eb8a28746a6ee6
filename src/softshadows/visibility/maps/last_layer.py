"""The farthest surface in each texel of a shadow atlas: says whether something lies behind the nearest."""

from __future__ import annotations

import wgpu

from softshadows.gpu.device import Gpu
from softshadows.gpu.timing import PassTimer
from softshadows.visibility.maps.shadow_atlas import ShadowAtlas


class LastLayer:
    """The atlas's occluders drawn once more, into the same views, with the depth test turned round.

    `view` holds closeness like the atlas, 1 where there is nothing. For atlases whose maps are one chunk.
    """

    def __init__(self, gpu: Gpu, atlas: ShadowAtlas) -> None:
        assert atlas.plan.chunks == 1, "every chunk would need its own turn"
        size = atlas.plan.atlas_size
        self.bytes = 4 * size * size
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
        self.view = gpu.texture((size, size), "depth32float", usage, "the last layer").create_view()
        self._draws = atlas.record_draws(0, atlas.draw_programs("less"), clears_views=False)

    def encode(self, encoder: wgpu.GPUCommandEncoder, timer: PassTimer) -> None:
        """After the atlas's own draw, which has found the views."""
        attachment = {
            "view": self.view,
            "depth_load_op": "clear",
            "depth_store_op": "store",
            "depth_clear_value": 1.0,
        }
        draw = encoder.begin_render_pass(
            color_attachments=[], depth_stencil_attachment=attachment, timestamp_writes=timer.writes("last_layer")
        )
        draw.execute_bundles([self._draws])
        draw.end()
