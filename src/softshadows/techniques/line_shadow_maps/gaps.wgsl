// Light through gaps that neither end of a segment sees: looked for along the row of both maps.
//
// In a row of rectified maps, a receiver at (u, inverse depth c) sees the light x metres from the map's sample along the straight
// line that leaves (u, c) at slope 1 / x. So every texel in front of the receiver hides a known stretch of the light, and a
// surface that goes on to the next texel hides what lies between. Neither map shows all surfaces: both together hide what they
// can. The segment is judged in BINS parts, one bit each.

//#include "visibility/line_maps/line_map.wgsl"
//#include "visibility/line_maps/segment_parts.wgsl"

const BINS = 32u;
const SMOOTH_JUMP_TEXELS = 2.0;  // of its distance, over which a surface goes on to the next texel at any slope
const SMOOTH_SLOPES = 2.0;       // or this many times as far as from the texel before

// The parts whose middle lies between two shares of the segment.
fn bins_between(from_share: f32, to_share: f32) -> u32 {
    return bits_between(first_part(min(from_share, to_share), BINS), first_part(max(from_share, to_share), BINS));
}

// Parts that a map's surfaces hide, and parts that something beyond the map's border may hide.
struct Hidden {
    bins: u32,
    unknown: u32,
};

// What the map's surfaces hide of the segment, counted from its sample on: towards larger u for `direction` 1, smaller for -1.
// `nearest` is the inverse depth of the row's nearest surface.
fn hidden_bins(map_sample: MapSample, length: f32, direction: f32, nearest: f32) -> Hidden {
    let view = shadow_views[map_sample.view];
    let texel = covering_texel(map_sample);
    let extent = 1.0 / view.texels_per_unit.x;
    let v = view.window_low.y + (f32(texel.y) + 0.5) / view.texels_per_unit.y;
    let inverse_depth = plane_inverse_depth(map_sample.plane_normal, map_sample.plane_offset, vec2f(map_sample.position.x, v));
    let rise = map_sample.plane_normal.x * extent * direction / map_sample.plane_offset;  // of the receiver's plane, per texel
    let bias = SNAP_BIAS_TEXELS * abs(rise) + CURVATURE_BIAS_TEXELS * inverse_depth_of_extent(inverse_depth, extent);
    let farthest = length * max(nearest - inverse_depth, 0.0);  // where that would hide the segment's other end
    let steps = u32(clamp(farthest / extent + 1.0, 0.0, f32(view.size.x)));

    var hidden = 0u;
    var column = i32(texel.x);
    let step = i32(direction);
    // How far the texel's centre lies from the receiver, in the walk's direction.
    var away = (column_position(map_sample.view, f32(column)) - map_sample.position.x) * direction;
    var on_plane = inverse_depth + rise * away / extent;
    var before = 0.0;   // inverse depth, share and change of the texel before
    var before_share = 0.0;
    var before_change = 0.0;
    for (var i = 0u; i <= steps; i++) {
        if column < 0 || column >= i32(view.size.x) {
            return Hidden(hidden, bins_between(away / farthest, 1.0));
        }
        if hidden == 0xffffffffu {
            break;
        }
        let here = map_inverse_depth(map_sample.view, vec2u(u32(column), texel.y));
        let change = here - before;
        if here > on_plane + bias {
            let scale = 1.0 / ((here - inverse_depth) * length);
            let share = away * scale;
            hidden |= bins_between(share - EDGE_TEXELS * extent * scale, share + EDGE_TEXELS * extent * scale);
            let smooth_change = max(SMOOTH_JUMP_TEXELS * inverse_depth_of_extent(here, extent), SMOOTH_SLOPES * abs(before_change));
            if before > 0.0 && abs(change) <= smooth_change {
                hidden |= bins_between(before_share, share);
            }
            before = here;
            before_share = share;
        } else {
            before = 0.0;
        }
        before_change = change;
        column += step;
        away += extent;
        on_plane += rise;
    }
    return Hidden(hidden, 0u);
}

// The share of the segment between the ends' own shares that neither map's surfaces hide. What neither map shows counts
// `unknown_weight`.
fn share_between(start: MapSample, end: MapSample, length: f32, shares: vec2f, nearest: vec2f, unknown_weight: f32) -> f32 {
    let margins = select(vec2f(0.0), vec2f(1.0 / f32(BINS)), shares > vec2f(0.0));
    let between = bins_between(shares.x + margins.x, 1.0 - shares.y - margins.y);
    if between == 0u || shares.x + shares.y >= 1.0 {
        return 0.0;
    }
    let from_start = hidden_bins(start, length, 1.0, nearest.x);
    var open = between & ~from_start.bins;
    if open == 0u {
        return 0.0;
    }
    let from_end = hidden_bins(end, length, -1.0, nearest.y);
    open &= ~reverseBits(from_end.bins);
    let unknown = open & (from_start.unknown | reverseBits(from_end.unknown));
    return (f32(countOneBits(open & ~unknown)) + unknown_weight * f32(countOneBits(unknown))) / f32(BINS);
}
