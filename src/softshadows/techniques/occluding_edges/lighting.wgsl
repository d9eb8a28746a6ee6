// Every pixel's visibility: segment by segment of the light, by the edges that the maps at its ends know.

//#include "edge_map.wgsl"
//#include "visibility/line_maps/ends.wgsl"
//#include "share.wgsl"
//#include "influence.wgsl"
//#include "search.wgsl"
//#include "passes/gbuffer/pixel.wgsl"

@group(3) @binding(0) var edge_map: texture_2d<u32>;
@group(3) @binding(1) var<storage, read> cells: array<f32>;  // the greatest inverse depth in each cell of every row
@group(3) @binding(2) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(3) var<storage, read> influence: array<vec2f>;  // f at even places along a segment, its integral up to there

override is_searched: bool;          // for what hides the light, or by the edge at the fragment's texel, as in the paper
override edge_rows: u32;             // that are interpolated: 1 for none, 2 as in the paper, 4

const SEEN_TEXELS = 2.0;  // by how much two maps may differ on one surface, as disparity

// What is lit of a segment from one of its ends, up to the first edge. `found`: there is an edge.
struct Part {
    found: bool,
    share: f32,
};

fn look_from(sample: u32, receiver: Receiver) -> Look {
    let map_sample = line_map_sample(sample, receiver);
    let view = shadow_views[map_sample.view];
    let texel_extent = 1.0 / view.texels_per_unit;
    let texel = (map_sample.position - view.window_low) * view.texels_per_unit - 0.5;
    let by_column = vec2f(texel_extent.x, 0.0);
    let by_row = vec2f(0.0, texel_extent.y);
    let next_column = plane_inverse_depth(map_sample.plane_normal, map_sample.plane_offset, map_sample.position + by_column);
    let next_row = plane_inverse_depth(map_sample.plane_normal, map_sample.plane_offset, map_sample.position + by_row);
    let texel_inverse_depth = inverse_depth_of_extent(map_sample.inverse_depth, max(texel_extent.x, texel_extent.y));
    return Look(
        sample,
        map_sample_is_lit(map_sample),
        is_rectified(map_sample),
        map_sample.view,
        texel,
        map_sample.position.x,
        map_sample.inverse_depth,
        vec2f(next_column, next_row) - map_sample.inverse_depth,
        CURVATURE_BIAS_TEXELS * texel_inverse_depth,
    );
}

// [Reimann2016 §3.4 substep 4.2] Weights of the rows around a place between them, `along` from the second one's centre: none
// but the nearest, the paper's linear ones, or a cubic B-spline's, which is smooth where an edge steps from column to column.
fn row_weights(along: f32) -> vec4f {
    if edge_rows == 1u {
        return vec4f(0.0, select(0.0, 1.0, along < 0.5), select(0.0, 1.0, along >= 0.5), 0.0);
    }
    if edge_rows == 2u {
        return vec4f(0.0, 1.0 - along, along, 0.0);
    }
    let back = 1.0 - along;
    let distances = vec2f(along, back);
    let inner = 4.0 + distances * distances * (3.0 * distances - 6.0);
    return vec4f(back * back * back, inner, along * along * along) / 6.0;
}

// The share that the edge in this entry of the edge map leaves of the segment.
fn share_before(entry: u32, look: Look, row: u32, side: u32) -> f32 {
    let column = (entry & ~EDGE_JUMPS) - 1u;
    // Where the map jumps, the edge lies between its last texel and the first one of what is behind.
    let border = select(0.0, 0.5 * direction(side), (entry & EDGE_JUMPS) != 0u);
    let edge_position = column_position(look.view, f32(column) - border);
    let edge_inverse_depth = map_inverse_depth(look.view, vec2u(column, row));
    let ahead = direction(side) * (edge_position - look.position);
    return visible_share(ahead, edge_inverse_depth - look.inverse_depth, segment_length(look.sample, side));
}

fn edge_entry(view: ShadowView, texel: vec2u, side: u32) -> u32 {
    return entry_in(textureLoad(edge_map, entry_word(view, texel, side), 0).x, texel.x);
}

// What the edge at the texel of the fragment, or `beside` it, leaves of the segment.
fn lit_part(look: Look, side: u32, beside: i32) -> Part {
    let view = shadow_views[look.view];
    let last = vec2i(view.size) - 1;
    let column = clamp(i32(round(look.texel.x)) + beside, 0, last.x);
    let first_row = i32(floor(look.texel.y)) - 1;
    let weights = row_weights(fract(look.texel.y));
    var weight = 0.0;
    var share = 0.0;
    let unused = select(1, 0, edge_rows == 4u);  // rows before and after
    for (var i = unused; i < 4 - unused; i++) {
        let row = u32(clamp(first_row + i, 0, last.y));
        let entry = edge_entry(view, vec2u(u32(column), row), side);
        if weights[i] > 0.0 && entry != NO_EDGE {
            weight += weights[i];
            share += weights[i] * share_before(entry, look, row, side);
        }
    }
    return Part(weight > 0.0, select(1.0, share / max(weight, 1e-6), weight > 0.0));
}

fn has_edge(look: Look, side: u32) -> bool {
    let size = vec2f(shadow_views[look.view].size);
    let texel = vec2u(clamp(round(look.texel), vec2f(0.0), size - 1.0));
    return edge_entry(shadow_views[look.view], texel, side) != NO_EDGE;
}

// What the segment's ends see of each other's blind spots. Edges tell where there is something to be found.
fn searched_influence(first: Look, second: Look) -> vec2f {
    if first.lit && second.lit && !has_edge(first, AFTER) && !has_edge(second, BEFORE) {
        return influence_between(0.0, 1.0);
    }
    return influence_of_rest(hidden_parts(first, AFTER) | from_other_end(hidden_parts(second, BEFORE)));
}

// Does the sample at the segment's other end see what this sample's map shows at the fragment's texel? Then its map has much the
// same inverse depth at the corresponding texel.
fn other_sees_texel(look: Look, other: Look, side: u32) -> bool {
    let last = vec2f(shadow_views[look.view].size) - 1.0;
    let texel = clamp(round(look.texel), vec2f(0.0), last);
    let inverse_depth = map_inverse_depth(look.view, vec2u(texel));
    let texels_per_unit = shadow_views[look.view].texels_per_unit.x;
    let reach = segment_length(look.sample, side) * texels_per_unit;
    let apart = column_position(look.view, texel.x) - column_position(other.view, 0.0);
    let moved = apart * texels_per_unit - direction(side) * reach * inverse_depth;
    let there = map_inverse_depth(other.view, vec2u(vec2f(clamp(round(moved), 0.0, last.x), texel.y)));
    return (there - inverse_depth) * reach <= SEEN_TEXELS;
}

// What the edge leaves of the segment from this end. For a fragment that only this end sees, `is_alone`, whose texel has no
// edge, one of the texels beside it does: it lies within a texel of an end of the penumbra.
fn part_from(look: Look, side: u32, is_alone: bool) -> Part {
    let part = lit_part(look, side, 0);
    var shares = 0.0;
    var count = 0.0;
    for (var beside = select(2, -1, is_alone && !part.found); beside <= 1; beside += 2) {
        let other = lit_part(look, side, beside);
        shares += select(0.0, other.share, other.found);
        count += select(0.0, 1.0, other.found);
    }
    return Part(part.found || count > 0.0, select(part.share, shares / max(count, 1.0), count > 0.0));
}

// [Reimann2016 §3.4 substep 4.4] Merging, which the paper leaves open: lit up to one edge from one end and up to another from the
// other. What a fragment sees that neither end does is what both leave.
fn merged_influence(first_is_lit: bool, second_is_lit: bool, shares: vec2f) -> vec2f {
    let low = select(1.0 - shares.y, 0.0, first_is_lit);
    let high = select(shares.x, 1.0, second_is_lit);
    return influence_between(low, high);
}

// [Reimann2016 §3.4 substep 4.1] What lies at a penumbra's texel is in that penumbra, seen or not, unless both samples see it.
// Both ends are looked at in loops, which a fragment that has no use for them skips (gpu/driver.wgsl).
fn edge_influence(first: Look, second: Look) -> vec2f {
    let seen = u32(first.lit) + u32(second.lit);
    var shares = vec2f(1.0);
    var is_found = false;
    for (var side = select(2u, AFTER, seen < 2u); side <= BEFORE; side++) {
        var look = first;
        var other = second;
        if side == BEFORE {
            look = second;
            other = first;
        }
        for (var turns = select(1u, 0u, seen > 0u && !look.lit); turns > 0u; turns--) {
            let part = part_from(look, side, seen == 1u);
            if seen > 0u || (part.found && !other_sees_texel(look, other, side)) {
                shares[side] = part.share;
                is_found = true;
            }
        }
    }
    return merged_influence(first.lit, second.lit, select(vec2f(0.0), shares, seen > 0u || is_found));
}

fn segment_influence(first: Look, second: Look) -> vec2f {
    if !first.rectified || !second.rectified || light.half_width == 0.0 {
        return influence_between(select(0.5, 0.0, first.lit), select(0.5, 1.0, second.lit));  // each end its half
    }
    if is_searched {
        return searched_influence(first, second);
    }
    return edge_influence(first, second);
}

@compute @workgroup_size(8, 8)
fn cs_lighting(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    var before = look_from(0u, receiver);
    if light_samples.count == 1u {
        visibility[receiver.index] = select(0.0, 1.0, before.lit);
        return;
    }
    let whole = influence_between(0.0, 1.0);
    var shading: Shading;
    for (var sample = 1u; sample < light_samples.count; sample++) {
        let here = look_from(sample, receiver);
        let lit = segment_influence(before, here);
        shading = with_segment(shading, sample - 1u, sample, receiver, lit, whole);
        before = here;
    }
    visibility[receiver.index] = visibility_of(shading);
}
