"""Ray-traced truth: the visibility every technique is measured against, and the closed forms that check it in turn.

    visibility                the share of each light seen from each pixel, by stratified rays: Embree's or the GPU's
    visibility_from_points    hard visibility of single light points: splits map error from light-sampling error
    Occluders                 the scene's triangles, to be asked with arbitrary segments
    closed_form               the analytic oracles O1 to O12

Embree is loaded when the first ray is cast, not when this package is imported.
"""

from softshadows.truth import alpha, closed_form
from softshadows.truth.occluders import Occluders
from softshadows.truth.visibility import visibility, visibility_from_points

__all__ = ["Occluders", "alpha", "closed_form", "visibility", "visibility_from_points"]
