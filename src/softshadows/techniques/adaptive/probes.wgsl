// Where a tile's probes are kept: for each tile, rows of the deepest cells from which some pixel saw nothing, then something.

//#include "tree.wgsl"

const DEEPEST_CELLS = 16u;   // along a side of the light, at most

fn probe_index(tile: u32, answer: u32, row: u32) -> u32 {
    return (tile * 2u + answer) * DEEPEST_CELLS + row;
}

// The deepest cells along the light's columns and rows.
fn probed_cells() -> vec2u {
    return max(vec2u(shape.columns, shape.sample_rows) - 1u, vec2u(1u));
}
