// The edge map: for every texel of a line light's rectified maps, the edges that hide a part of the light from it.
//
// Entries are half words. A view's rows hold those of the segment after the map's sample, two columns a word, and then those of
// the segment before it. An entry is 0 where the texel's order is kept, and else 1 + the edge's column in its view, with
// EDGE_JUMPS where the map jumps in depth beside the edge.

//#include "visibility/line_maps/line_map.wgsl"

const AFTER = 0u;   // towards the next sample, +u: penumbrae lie at smaller u than their edges
const BEFORE = 1u;  // towards the sample before, -u: the mirror image
const NO_EDGE = 0u;
const EDGE_JUMPS = 0x8000u;
const CELLS = 64u;  // stretches of a row, each walked by one lane

// 1 or -1: u, seen in the direction in which the rows of this layer are alike.
fn direction(side: u32) -> f32 {
    return select(1.0, -1.0, side == BEFORE);
}

// Where in the edge map the word lies that holds a texel's entry.
fn entry_word(view: ShadowView, texel: vec2u, side: u32) -> vec2u {
    let words = (view.size.x + 1u) / 2u;
    return view.origin + vec2u(texel.x / 2u + side * words, texel.y);
}

fn entry_in(word: u32, column: u32) -> u32 {
    return extractBits(word, 16u * (column % 2u), 16u);
}

// Is there a segment of the light on this side of the sample? And how long is it, in metres?
fn has_segment(sample: u32, side: u32) -> bool {
    return select(sample + 1u < light_samples.count, sample > 0u, side == BEFORE);
}

fn segment_length(sample: u32, side: u32) -> f32 {
    let neighbor = select(sample + 1u, sample - 1u, side == BEFORE);
    return abs(light_samples.points[neighbor].x - light_samples.points[sample].x);
}

// Columns of a cell of a row: whole words of the edge map.
fn cell_width(view: u32) -> u32 {
    return 2u * ((shadow_views[view].size.x + 2u * CELLS - 1u) / (2u * CELLS));
}

// The first cell of a row, where the rows of all faces of all samples follow each other.
fn first_cell(sample: u32, number: u32) -> u32 {
    return (first_row(sample) + number) * CELLS;
}
