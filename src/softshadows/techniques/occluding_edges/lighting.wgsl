// Every pixel's visibility: segment by segment of the light, by the edges that the maps at its ends know.

//#include "receiver.wgsl"
//#include "edge_map.wgsl"
//#include "share.wgsl"
//#include "search.wgsl"
//#include "pixel.wgsl"

@group(3) @binding(0) var edge_map: texture_2d<u32>;
@group(3) @binding(1) var<storage, read> cells: array<f32>;  // the greatest closeness in each cell of every row
@group(3) @binding(2) var<storage, read_write> visibility: array<f32>;

override penumbra: u32;              // how fragments are found to lie in one: BY_TEXTURE as in the paper, BY_SIGHT, BY_SEARCH
override edge_rows: u32;             // that are interpolated: 1 for none, 2 as in the paper, 4

const SEEN_TEXELS = 2.0;  // by how much two maps may differ on one surface, as disparity

const BY_TEXTURE = 0u;
const BY_SIGHT = 1u;
const BY_SEARCH = 2u;

// What is lit of a segment from one of its ends, up to the first edge. `found`: there is an edge.
struct Part {
    found: bool,
    share: f32,
};

fn look_from(sample: u32, receiver: LightReceiver) -> Look {
    let sight = line_sight(sample, receiver);
    let view = shadow_views[sight.view];
    let texel_extent = 1.0 / view.texels_per_unit;
    let texel = (sight.position - view.window_low) * view.texels_per_unit - 0.5;
    let by_column = vec2f(texel_extent.x, 0.0);
    let by_row = vec2f(0.0, texel_extent.y);
    let next_column = plane_closeness(light, sight.plane_normal, sight.plane_offset, sight.position + by_column);
    let next_row = plane_closeness(light, sight.plane_normal, sight.plane_offset, sight.position + by_row);
    let texel_closeness = closeness_of_extent(light, sight.closeness, max(texel_extent.x, texel_extent.y));
    return Look(
        sample,
        sight_is_lit(sight),
        is_rectified(sight),
        sight.view,
        texel,
        sight.position.x,
        sight.closeness,
        vec2f(next_column, next_row) - sight.closeness,
        light.bias_scale * CURVATURE_BIAS_TEXELS * texel_closeness,
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
    let edge_closeness = map_closeness(look.view, vec2u(column, row));
    let ahead = direction(side) * (edge_position - look.position);
    return visible_share(ahead, edge_closeness - look.closeness, segment_length(look.sample, side));
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
    for (var i = 0; i < 4; i++) {
        let row = u32(clamp(first_row + i, 0, last.y));
        let entry = entry_of(textureLoad(edge_map, view.origin + vec2u(u32(column), row), 0).x, side);
        if weights[i] > 0.0 && entry != NO_EDGE {
            weight += weights[i];
            share += weights[i] * share_before(entry, look, row, side);
        }
    }
    return Part(weight > 0.0, select(1.0, share / max(weight, 1e-6), weight > 0.0));
}

// For a fragment that only one end sees. Where its texel has no edge it lies within a texel of an end of the penumbra.
fn seen_share(look: Look, side: u32) -> f32 {
    let own = lit_part(look, side, 0);
    if own.found {
        return own.share;
    }
    let onward = lit_part(look, side, 1);
    let back = lit_part(look, side, -1);
    if onward.found && back.found {
        return 0.5 * (onward.share + back.share);
    }
    return select(back.share, onward.share, onward.found);
}

fn has_edge(look: Look, side: u32) -> bool {
    let size = vec2f(shadow_views[look.view].size);
    let texel = vec2u(clamp(round(look.texel), vec2f(0.0), size - 1.0));
    return entry_of(textureLoad(edge_map, shadow_views[look.view].origin + texel, 0).x, side) != NO_EDGE;
}

// What the segment's ends see of each other's blind spots. Edges tell where there is something to be found.
fn searched_visibility(first: Look, second: Look) -> f32 {
    if first.lit && second.lit && !has_edge(first, AFTER) && !has_edge(second, BEFORE) {
        return 1.0;
    }
    return share_of_rest(
        hidden_parts(first, AFTER),
        from_other_end(hidden_parts(second, BEFORE)),
    );
}

// Only what a sample sees lies in its penumbrae.
fn seen_visibility(first: Look, second: Look) -> f32 {
    if first.lit && second.lit {
        return share_in_either(lit_part(first, AFTER, 0).share, lit_part(second, BEFORE, 0).share);
    }
    if first.lit {
        return seen_share(first, AFTER);
    }
    if second.lit {
        return seen_share(second, BEFORE);
    }
    return 0.0;
}

// Does the sample at the segment's other end see what this sample's map shows at the fragment's texel? Then its map has much the
// same closeness at the corresponding texel.
fn other_sees_texel(look: Look, other: Look, side: u32) -> bool {
    let last = vec2f(shadow_views[look.view].size) - 1.0;
    let texel = clamp(round(look.texel), vec2f(0.0), last);
    let closeness = map_closeness(look.view, vec2u(texel));
    let texels_per_unit = shadow_views[look.view].texels_per_unit.x;
    let reach = segment_length(look.sample, side) * texels_per_unit;
    let apart = column_position(look.view, texel.x) - column_position(other.view, 0.0);
    let moved = apart * texels_per_unit - direction(side) * reach * closeness;
    let there = map_closeness(other.view, vec2u(vec2f(clamp(round(moved), 0.0, last.x), texel.y)));
    return (there - closeness) * reach <= SEEN_TEXELS;
}

// [Reimann2016 §3.4 substep 4.1] What lies at a penumbra's texel is in that penumbra, seen or not. A penumbra is what only one
// sample sees.
fn textured_visibility(first: Look, second: Look) -> f32 {
    if first.lit || second.lit {
        return select(seen_visibility(first, second), 1.0, first.lit && second.lit);
    }
    var from_first = lit_part(first, AFTER, 0);
    var from_second = lit_part(second, BEFORE, 0);
    from_first.found = from_first.found && !other_sees_texel(first, second, AFTER);
    from_second.found = from_second.found && !other_sees_texel(second, first, BEFORE);
    if !from_first.found && !from_second.found {
        return 0.0;
    }
    return share_in_both(select(1.0, from_first.share, from_first.found), select(1.0, from_second.share, from_second.found));
}

fn segment_visibility(first: Look, second: Look) -> f32 {
    if !first.rectified || !second.rectified || light.half_width == 0.0 {
        return 0.5 * (select(0.0, 1.0, first.lit) + select(0.0, 1.0, second.lit));
    }
    switch penumbra {
        case BY_TEXTURE: { return textured_visibility(first, second); }
        case BY_SIGHT: { return seen_visibility(first, second); }
        default: { return searched_visibility(first, second); }
    }
}

@compute @workgroup_size(8, 8)
fn cs_lighting(@builtin(global_invocation_id) id: vec3u) {
    let pixel = begin_pixel(id.xy);
    if !pixel.is_surface {
        return;
    }
    var before = look_from(0u, pixel.receiver);
    var visible = select(0.0, 1.0, before.lit);
    if light.sample_count > 1u {
        visible = 0.0;
    }
    for (var sample = 1u; sample < light.sample_count; sample++) {
        let here = look_from(sample, pixel.receiver);
        visible += segment_visibility(before, here);
        before = here;
    }
    visibility[pixel.index] = visible / f32(max(light.sample_count, 2u) - 1u);
}
