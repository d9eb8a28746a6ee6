"""How far a visibility image is from the truth: numpy in, numbers out, no GPU and no scene.

compare                  every figure of one image against one truth, as a Comparison
leak_mask, false_shadow_mask, signed_error_image      where the visible failures are
penumbra_width, penumbra_width_error                  how wide the soft part is
worst_region             where the errors are largest
flip                     the perceived difference of two finished pictures
"""

from softshadows.metrics.error import Comparison, compare
from softshadows.metrics.flip import flip
from softshadows.metrics.leaks import Regions, false_shadow_mask, leak_mask, regions, signed_error_image
from softshadows.metrics.penumbra import penumbra_width, penumbra_width_error
from softshadows.metrics.worst import Region, worst_region

__all__ = [
    "Comparison",
    "Region",
    "Regions",
    "compare",
    "false_shadow_mask",
    "flip",
    "leak_mask",
    "penumbra_width",
    "penumbra_width_error",
    "regions",
    "signed_error_image",
    "worst_region",
]
