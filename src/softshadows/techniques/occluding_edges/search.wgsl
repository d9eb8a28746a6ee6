// Everything in a row that hides a part of a segment of the light from a fragment: the edges inside the penumbra, too.
//
// A texel at u, inverse depth w, hides from a fragment at u', w' the point of the segment that lies (u - u') / (w - w') from the
// map's sample. Walking along the row away from the fragment, what is hidden is gathered as bits, one for each part of the
// segment. That is what the paper asks for under "Detecting Edges in the Penumbra", without further layers.

//#needs EDGE_TEXELS, cell_width, cells, direction, first_cell, map_inverse_depth, row_number, segment_length, shadow_views
//#include "visibility/line_maps/segment_parts.wgsl"

// What a sample knows of a fragment: whether it sees it, and how; and where that is in the map, from its texels' centres.
struct Look {
    sample: u32,
    lit: bool,
    rectified: bool,
    view: u32,
    texel: vec2f,
    position: f32,
    inverse_depth: f32,
    slope: vec2f,  // by which the inverse depth of its plane changes from column to column, and from row to row
    bias: f32,     // of inverse depth, for surfaces that curve within a texel
};

const PARTS = 128u;
const ALL = vec4u(0xffffffffu);

// The parts whose middles lie between two shares of the segment.
fn parts_between(low: f32, high: f32) -> vec4u {
    let first = first_part(low, PARTS);
    let end = first_part(high, PARTS);
    return vec4u(
        bits_between(first, end),
        bits_between(first - 32, end - 32),
        bits_between(first - 64, end - 64),
        bits_between(first - 96, end - 96),
    );
}

// The parts of the segment beyond `look`'s sample that something in its map hides, as bits counted from that sample.
fn hidden_parts(look: Look, side: u32) -> vec4u {
    let width = i32(shadow_views[look.view].size.x);
    let row = u32(clamp(i32(round(look.texel.y)), 0, i32(shadow_views[look.view].size.y) - 1));
    let own_inverse_depth = look.inverse_depth + look.slope.y * (f32(row) - look.texel.y);  // of its plane, in that row
    let cell = i32(cell_width(look.view));
    let cell_base = first_cell(look.sample, row_number(look.view, row));
    let forth = i32(direction(side));
    let reach = segment_length(look.sample, side) * shadow_views[look.view].texels_per_unit.x;

    var hidden = vec4u(0u);
    var column = clamp(i32(round(look.texel.x)), 0, width - 1);
    var last_end = 0.0;  // up to which share the texel before hid the segment; negative where it did not
    if look.lit {
        column += forth;  // its own texel is the hard test's business
        last_end = -1.0;
    }
    while column >= 0 && column < width && any(hidden != ALL) {
        // A cell of which nothing is close enough to be between the fragment and the segment is passed at once.
        let ahead = f32(forth) * (f32(column) - look.texel.x);
        let in_cell = column / cell;
        if (cells[cell_base + u32(in_cell)] - own_inverse_depth) * reach <= ahead - 1.0 {
            column = select(in_cell * cell - 1, (in_cell + 1) * cell, forth > 0);
            last_end = -1.0;
            continue;
        }
        let closer = map_inverse_depth(look.view, vec2u(u32(column), row)) - own_inverse_depth;
        let moves = closer * reach;
        let is_before_plane = closer > look.slope.x * (f32(column) - look.texel.x) + look.bias;
        if is_before_plane && moves > ahead - 1.0 && moves > 0.0 {
            let end = (ahead + EDGE_TEXELS) / moves;
            let start = (ahead - EDGE_TEXELS) / moves;
            // Neighbours that both hide something are one surface, however steep.
            let joined = select(start, min(start, last_end), last_end >= 0.0);
            hidden |= parts_between(joined, max(end, last_end));
            last_end = end;
        } else {
            last_end = -1.0;
        }
        column += forth;
    }
    return hidden;
}

// The same parts, counted from the segment's other end.
fn from_other_end(parts: vec4u) -> vec4u {
    return reverseBits(parts.wzyx);
}

// How much of the segment is not hidden.
fn share_of_rest(hidden: vec4u) -> f32 {
    let count = countOneBits(hidden);
    return 1.0 - f32(count.x + count.y + count.z + count.w) / f32(PARTS);
}
