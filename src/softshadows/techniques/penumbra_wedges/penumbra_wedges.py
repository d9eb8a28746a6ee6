"""Penumbra wedges: how much of the light each silhouette hides, exactly, from its edges; overlapping shadows blended.

Paper
    [Forest2006]  Forest, Barthe, Paulin, "Realistic Soft Shadows by Penumbra-Wedges Blending", Graphics Hardware 2006,
    on Akenine-Möller and Assarsson, "Approximate Soft Shadows on Arbitrary Surfaces using Penumbra Wedges", EGRW 2002.
    [Laine2005]  Laine, Aila, Assarsson, Lehtinen, Akenine-Möller, "Soft Shadow Volumes for Ray Tracing", SIGGRAPH 2005,
    for `blending="union"`.

Section map
    [Forest2006 §2]    standard and probabilistic wedges             -> wedges.wgsl blend_object()
    [Forest2006 §3]    a buffer per silhouette, blended in turn      -> wedges.wgsl add_occluders()
    [Forest2006 §3.1]  silhouette visibility buffer                  -> parts.wgsl begin_silhouette() add_edge()
    [Forest2006 §3.2]  blending, the formula of ε                    -> parts.wgsl blend_silhouette() overlap()
    [Forest2006 §4.1]  silhouette edges                              -> silhouettes.wgsl cs_edges()
    [Forest2006 §4.1]  shadow volumes, z-fail                        -> layers.wgsl layers_in()
    [Forest2006 §4.2]  which receivers a wedge concerns              -> shaft.wgsl segment_in_shaft()
    [Forest2006 §4.2]  local near plane, clipping to the light       -> coverage.wgsl clip_to_quarter()
    [Forest2006 §4.3]  occluded share per part, bounding rectangle   -> parts.wgsl add_chord() finish_rectangle()
    [Forest2006 §6]    centre of gravity                             -> parts.wgsl tilted_product()
    [Laine2005 §3]     layers over points of the light               -> union.wgsl add_silhouette()
    [Laine2005 §4]     edges that are silhouettes of any point       -> silhouettes.wgsl cs_edges()

Departures from the paper
    - No wedges and shadow volumes are drawn. Tiles of 8×8 receivers gather the edges and triangles that can hide the
      light from any of them (shaft culling), and every receiver integrates its edges in a compute shader. A receiver
      outside a wedge finds that the edge misses the light, so the result is the same, without stencil buffers, 48 MB of
      targets and passes per silhouette; and the camera may be anywhere.
    - Whether the light's centre is hidden is counted from the triangles between it and the receiver, exactly where the
      edges say that it changes: both ask one predicate, so no pixel flips.
    - `blending.rect=exact` is the default: the paper's rectangle misses corners of a quarter that are occluded without
      an edge there. Floats in place of the paper's 8 bits, a quarter never more than full, a rectangle never more than
      covered. docs/decisions/0012-penumbra-wedges.md has them measured.
    - Silhouettes are connected components, blended front to back. One that is not closed counts as two sheets, what
      turns its front and what turns its back to the light: exact for cards, whose border is always a silhouette.
      Edges with any number of triangles change the count of layers by what lies left and right of them, so holes,
      flipped and doubled faces, T-junctions and Möbius strips make no streaks.
    - A tile with much in its shaft pauses before a driver gives it up, and the next dispatch goes on with what its
      receivers know, to the same bits (dispatches.py).
    - The part of the light below a receiver's horizon counts as invisible; the paper leaves that to shading.
    - `blending.centre_of_gravity` is the paper's future work, which says no more than its name: regions are spread over
      their rectangles with a density that rises linearly towards it.
    - `blending="union"` goes beyond: layers are counted over 256 points of the light, from silhouettes of the receiver
      itself. Any occluders unite exactly; what is left is the light's sampling.

Use when
    shadows must have no resolution: contact, thin things, large distances. `union` for correctness with any number of
    occluders; `overlap` for smooth penumbrae of simple ones.
Fails when
    silhouettes are taken from the light's centre (all but `union`): a box with depth under a large light is too bright
    (scene `blocker` with a box; docs/decisions/0012-penumbra-wedges.md). `additive` is too dark where shadows overlap
    (scene `sphere_cube`), `probabilistic` less so. An object that overlaps itself counts twice. `union` shows bands of
    1/16 under edges that run along its rows, 3.6° off the light's sides. Geometry that cuts through the light, which is
    reported.
Inputs
    rectangle lights. Scenes without alpha masks.
Cost
    every pixel looks at the edges and triangles in its tile's shaft: time grows with the geometry near the light's
    path, not with its width. 48 bytes per edge, 32 per triangle; none per pixel
    of a small scene. From about 2600 edges on for `union`, and 25 000 edges and triangles for the others, receivers
    keep 288 and 672 bytes between dispatches, at most 64 MiB at once.
"""

from __future__ import annotations

from typing import ClassVar

from softshadows.techniques.base import Presets, RenderContext, Technique, TechniquePass
from softshadows.techniques.options import Choice, choice, one_of, option
from softshadows.techniques.penumbra_wedges.wedge_pass import WedgePass


class Additive(Choice):
    """Shares added up: standard wedges."""

    name: ClassVar[str] = "additive"


class Probabilistic(Choice):
    """Shares taken as independent of each other."""

    name: ClassVar[str] = "probabilistic"


class Overlap(Choice):
    """Shares blended by how the rectangles around them overlap: the paper's."""

    name: ClassVar[str] = "overlap"

    rect: str = option(
        default="exact",
        help="the rectangle around an occluded region: exact, or the paper's, its numbers in 8 bits",
        choices=("exact", "paper"),
    )
    centre_of_gravity: bool = option(
        default=False, help="know where in its rectangle a region lies", choices=(False, True)
    )


class Union(Choice):
    """Layers counted over 256 points of the light: any occluders unite exactly."""

    name: ClassVar[str] = "union"


class PenumbraWedges(Technique):
    """Exact coverage of the light by every silhouette's edges, blended. The module's text is its manual."""

    name: ClassVar[str] = "penumbra_wedges"
    light_kinds: ClassVar[frozenset[str]] = frozenset({"rect"})
    presets: ClassVar[Presets] = {"paper": {"blending.rect": "paper"}}

    blending: Additive | Probabilistic | Overlap | Union = choice(
        default=Overlap(),
        converter=one_of(Additive, Probabilistic, Overlap, Union),
        help="how silhouettes are combined: added, as independent, by the paper's overlap, or as a union of points",
    )

    def build(self, context: RenderContext) -> TechniquePass:
        if isinstance(self.blending, Union):
            return WedgePass(context, None)
        overlap = self.blending if isinstance(self.blending, Overlap) else Overlap()
        constants = {
            "blending": (Additive, Probabilistic, Overlap).index(type(self.blending)),  # as wedges.wgsl numbers them
            "exact_rectangles": overlap.rect == "exact",
            "eight_bits": overlap.rect == "paper",
            "uses_gravity": overlap.centre_of_gravity,
        }
        return WedgePass(context, constants)
