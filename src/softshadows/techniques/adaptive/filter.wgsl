// The visible share of the light from maps that are looked up again, with a filter: where the tree is coarse, bands become ramps.
//
// PCF [Schwaerzler2012 §3.4.3]: the texels around the receiver's, for the samples whose shadow's edge runs through the tile.
// CELL: each sample stands for the part of the light around it. From another point of that part, a blocker seen `ratio` times
// as close as the receiver covers what lies beside the receiver by (ratio - 1) times the step on the light.

//#include "visibility/maps/shadow_map.wgsl"
//#include "weights.wgsl"

@group(3) @binding(11) var<storage, read_write> visibility: array<f32>;

override pcf_texels: u32;    // along the kernel's side; 0: CELL
const CELL_TAPS = 3u;        // along a side
const BLOCKER_SLACK = 0.7;   // blockers of one silhouette differ in distance

var<workgroup> seen_by_some: array<atomic<u32>, MOST_ROWS>;
var<workgroup> seen_by_all: array<atomic<u32>, MOST_ROWS>;

fn bit_of(word: u32, column: u32) -> u32 {
    return (word >> column) & 1u;
}

// What a sample stands for in the pixel's tree.
struct Share {
    weight: f32,
    spacing: u32,   // of the coarsest leaf beside it
};

fn share_of(tree: u32, row: u32, column: u32) -> Share {
    var share = Share(0.0, 0u);
    for (var level = 0u; level <= shape.deepest; level++) {
        let width = spacing(level);
        if row % width != 0u || column % width != 0u {
            continue;
        }
        let cell_row = select(0u, row / width, shape.has_rows == 1u);
        var above = 0u;
        var below = 0u;
        if cell_row < cell_rows(level) {
            above = leaf_cells(tree, level, cell_row);
        }
        if cell_row > 0u || shape.has_rows == 0u {
            below = leaf_cells(tree, level, select(0u, cell_row - 1u, cell_row > 0u));
        }
        let left = column - min(column, right_shift(level));
        let beside = select(0u, 1u, column >= right_shift(level));
        let leaves = bit_of(above, column) + bit_of(below, column) + beside * (bit_of(above, left) + bit_of(below, left));
        if leaves == 0u {
            continue;
        }
        share.spacing = max(share.spacing, width);
        if paper_weights {
            share.weight = paper_weight(level);
        } else {
            share.weight += f32(leaves) * cell_area(level);
        }
    }
    return share;
}

// Is the receiver before what the texel holds, or that less than `nearest` times as close as the receiver?
fn tap_is_lit(map_sample: MapSample, texel: vec2u, nearest: f32) -> bool {
    let gap = texel_gap(map_sample, texel);
    return gap.texels <= 0.0 || gap.stored <= max(free_inverse_depth(map_sample), nearest * map_sample.inverse_depth)
        || (gap.texels < CREASE_TEXELS && occluder_surface_is_behind(map_sample, texel, gap.stored));
}

// [Schwaerzler2012 §3.4.3] The lit share of the texels around the receiver's.
fn filtered_by_pcf(sample: u32, receiver: Receiver) -> f32 {
    let map_sample = project_into_map(sample, receiver, receiver.position_ls);
    if !map_sample.possible || !map_sample.covered {
        return select(0.0, 1.0, map_sample.possible);
    }
    let view = shadow_views[map_sample.view];
    let position = (map_sample.position - view.window_low) * view.texels_per_unit;
    let start = position - 0.5 * f32(pcf_texels - 1u);
    var lit = 0.0;
    for (var i = 0u; i < pcf_texels * pcf_texels; i++) {
        let tap = clamp(start + vec2f(vec2u(i % pcf_texels, i / pcf_texels)), vec2f(0.0), vec2f(view.size) - 1.0);
        lit += select(0.0, 1.0, tap_is_lit(map_sample, vec2u(tap), 1.0));
    }
    return lit / f32(pcf_texels * pcf_texels);
}

// By how much the occluder that hides the sample is closer than the receiver; 0 where nothing is known.
fn blocker_ratio(sample: u32, receiver: Receiver) -> f32 {
    let map_sample = project_into_map(sample, receiver, receiver.position_ls);
    if !map_sample.possible || !map_sample.covered || light.is_directional == 1u {
        return 0.0;
    }
    return max(stored_inverse_depth(map_sample, covering_texel(map_sample)) / map_sample.inverse_depth, 1.0);
}

// The visible share of the part of the light that the sample stands for.
fn filtered_by_cell(sample: u32, receiver: Receiver, width: u32, ratio: f32) -> f32 {
    let point = light_samples.points[sample].xy;
    let extent = vec2f(light.half_width, light.half_height);
    let steps = vec2f(f32(max(shape.columns - 1u, 1u)), f32(max(shape.sample_rows - 1u, 1u)));
    let half_cell = select(extent / steps, max(extent.x, extent.y) / steps.xx, shape.has_rows == 0u) * f32(width);
    let low = max(point - half_cell, -extent) - point;
    let high = min(point + half_cell, extent) - point;
    var lit = 0.0;
    for (var i = 0u; i < CELL_TAPS * CELL_TAPS; i++) {
        let at = (vec2f(vec2u(i % CELL_TAPS, i / CELL_TAPS)) + 0.5) / f32(CELL_TAPS);
        let step = mix(low, high, at);
        let map_sample = project_into_map(sample, receiver, receiver.position_ls + vec3f(step * (ratio - 1.0), 0.0));
        // Only a blocker far enough from the receiver hides that point of the light, and not the sample.
        let share = abs(step) / max(half_cell, vec2f(1e-20));
        let nearest = 1.0 + BLOCKER_SLACK * max(share.x, share.y) * (ratio - 1.0);
        lit += select(0.0, 1.0, map_sample.possible && (!map_sample.covered || tap_is_lit(map_sample, covering_texel(map_sample), nearest)));
    }
    return lit / f32(CELL_TAPS * CELL_TAPS);
}

// The ratio of the occluder whose silhouette runs between the sample and those around it; 0 where they all see the same.
fn silhouette_ratio(receiver: Receiver, tile: u32, tree: u32, lane: u32, row: u32, column: u32, width: u32, is_seen: bool) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let beside = vec2i(vec2u(column, row)) + i32(width) * neighbour(i);
        if any(beside < vec2i(0)) || any(beside >= vec2i(vec2u(shape.columns, shape.sample_rows))) {
            continue;
        }
        let at = vec2u(beside);
        let is_known = bit_of(trees[request_index(tree, at.y)], at.x) == 1u;
        if !is_known || (bit_of(row_bits(tile, at.y, lane), at.x) == 1u) == is_seen {
            continue;
        }
        let hidden = select(vec2u(column, row), at, is_seen);
        let ratio = blocker_ratio(hidden.y * shape.columns + hidden.x, receiver);
        sum += ratio;
        count += select(0.0, 1.0, ratio > 0.0);
    }
    return select(0.0, sum / count, count > 0.0);
}

// What a pixel knows of the light by its look-ups.
struct Known {
    sees_some: bool,
    misses_some: bool,
};

fn known_of(pixel: TreePixel, lane: u32) -> Known {
    var known = Known(false, false);
    for (var row = 0u; row < shape.sample_rows; row++) {
        let asked = trees[request_index(pixel.tree, row)];
        if asked != 0u {
            let seen = row_bits(pixel.tile, row, lane) & asked;
            atomicOr(&seen_by_some[row], seen);
            atomicAnd(&seen_by_all[row], seen);
            known.sees_some |= seen != 0u;
            known.misses_some |= seen != asked;
        }
    }
    return known;
}

// The look-ups of a row of which a filter may know more.
fn uncertain_samples(row: u32, asked: u32, is_mixed: bool) -> u32 {
    if pcf_texels > 0u {
        return atomicLoad(&seen_by_some[row]) & ~atomicLoad(&seen_by_all[row]);
    }
    return select(0u, asked, is_mixed);
}

fn filtered(sample: vec2u, pixel: TreePixel, lane: u32, width: u32, is_seen: bool) -> f32 {
    let number = sample.y * shape.columns + sample.x;
    if pcf_texels > 0u {
        return filtered_by_pcf(number, pixel.receiver);
    }
    let ratio = silhouette_ratio(pixel.receiver, pixel.tile, pixel.tree, lane, sample.y, sample.x, width, is_seen);
    if ratio > 1.0 {
        return filtered_by_cell(number, pixel.receiver, width, ratio);
    }
    return f32(is_seen);
}

fn filtered_sum(pixel: TreePixel, lane: u32, is_mixed: bool) -> f32 {
    var visible = 0.0;
    var total = 0.0;
    for (var row = 0u; row < shape.sample_rows; row++) {
        let asked = trees[request_index(pixel.tree, row)];
        if asked == 0u {
            continue;
        }
        let seen = row_bits(pixel.tile, row, lane);
        let uncertain = uncertain_samples(row, asked, is_mixed);
        for (var rest = asked; rest != 0u; rest &= rest - 1u) {
            let column = firstTrailingBit(rest);
            let share = share_of(pixel.tree, row, column);
            let is_seen = bit_of(seen, column) == 1u;
            var lit = f32(is_seen);
            if bit_of(uncertain, column) == 1u {
                lit = filtered(vec2u(column, row), pixel, lane, share.spacing, is_seen);
            }
            visible += share.weight * lit;
            total += share.weight;
        }
    }
    return visible / total;
}

@compute @workgroup_size(TILE, TILE)
fn cs_filter(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    if lane < MOST_ROWS {
        atomicStore(&seen_by_some[lane], 0u);
        atomicStore(&seen_by_all[lane], 0xffffffffu);
    }
    let pixel = tree_pixel(group.xy, local.xy);
    let receivers = receivers_of_tile(pixel.receiver, lane);
    let has_work = pixel.receiver.is_surface && is_active(pixel.tree);
    var known = Known(false, false);
    if has_work {
        known = known_of(pixel, lane);
    }
    workgroupBarrier();
    if lane == 0u {
        count_lookups(pixel.tree, receivers);
    }
    if !pixel.exists {
        return;
    }
    let is_mixed = known.sees_some && known.misses_some;
    if !has_work {
        visibility[pixel.receiver.index] = visibility_without_tree(pixel.receiver);
    } else if pcf_texels == 0u && !is_mixed {
        visibility[pixel.receiver.index] = select(0.0, 1.0, known.sees_some);
    } else {
        visibility[pixel.receiver.index] = filtered_sum(pixel, lane, is_mixed);
    }
}
