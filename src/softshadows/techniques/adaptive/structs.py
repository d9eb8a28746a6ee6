"""What Python and the kernels of adaptive sampling share."""

from __future__ import annotations

from softshadows.gpu.layout import F32, U32, Struct, Vec2u


class TreeShape(Struct):
    """What the kernels know of the lattice, the picture and the options (tree.wgsl)."""

    image_size: Vec2u
    deepest: U32
    has_columns: U32
    has_rows: U32
    columns: U32
    sample_rows: U32
    sample_count: U32
    refined_rows: U32  # of cells above the deepest level
    is_global: U32
    sure_levels: U32  # the first levels: what a tile or the next sees a part of is refined without a test
    threshold: U32  # texels of a cell that may fail
    comparison_step: U32  # pixels from texel to texel of the comparison
    is_resident: U32  # all maps share the atlas for the whole frame
    largest_tile: U32
    atlas_size: U32
    has_probes: U32  # tiles refine what their rays' probes disagree about
    has_brackets: U32  # rays find the edges between a line's samples


class Step(Struct):
    """Where in the frame a dispatch stands: the level, its samples and draws, and the first map that the atlas holds.

    `samples` are the bits of a row of the level's samples, `older_samples` those of the level above.
    """

    level: U32
    samples: U32
    older_samples: U32
    samples_per_batch: U32
    first_chunk: U32
    first_rank: U32
    first_ray: U32  # of each pixel's on this level, and how many of them are traced
    rays: U32
    fineness: F32  # of the level's maps: texels along a pixel, over those of the first level
