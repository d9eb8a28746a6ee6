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

var<workgroup> receivers: atomic<u32>;
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

fn share_of(tree: u32, row: u32, column: u32, deepest: u32) -> Share {
    var share = Share(0.0, 0u);
    for (var level = 0u; level <= deepest; level++) {
        let width = spacing(level);
        if row % width != 0u || column % width != 0u {
            continue;
        }
        let cell_row = select(0u, row / width, shape.has_rows == 1u);
        var above = 0u;
        var below = 0u;
        if cell_row < cell_rows(level) {
            above = leaf_cells(tree, level, cell_row, deepest);
        }
        if cell_row > 0u || shape.has_rows == 0u {
            below = leaf_cells(tree, level, select(0u, cell_row - 1u, cell_row > 0u), deepest);
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
fn tap_is_lit(sight: Sight, texel: vec2u, nearest: f32) -> bool {
    let gap = texel_gap(sight, texel);
    return gap.texels <= 0.0 || gap.stored <= max(free_closeness(sight), nearest * sight.closeness)
        || (gap.texels < CREASE_TEXELS && occluder_surface_is_behind(sight, texel, gap.stored));
}

// [Schwaerzler2012 §3.4.3] The lit share of the texels around the receiver's.
fn filtered_by_pcf(sample: u32, receiver: LightReceiver) -> f32 {
    let sight = sight_through(sample, receiver, receiver.point);
    if !sight.possible || !sight.covered {
        return select(0.0, 1.0, sight.possible);
    }
    let view = shadow_views[sight.view];
    let position = (sight.position - view.window_low) * view.texels_per_unit;
    let start = position - 0.5 * f32(pcf_texels - 1u);
    var lit = 0.0;
    for (var i = 0u; i < pcf_texels * pcf_texels; i++) {
        let tap = clamp(start + vec2f(vec2u(i % pcf_texels, i / pcf_texels)), vec2f(0.0), vec2f(view.size) - 1.0);
        lit += select(0.0, 1.0, tap_is_lit(sight, vec2u(tap), 1.0));
    }
    return lit / f32(pcf_texels * pcf_texels);
}

// By how much the occluder that hides the sample is closer than the receiver; 0 where nothing is known.
fn blocker_ratio(sample: u32, receiver: LightReceiver) -> f32 {
    let sight = sight_through(sample, receiver, receiver.point);
    if !sight.possible || !sight.covered || light.is_directional == 1u {
        return 0.0;
    }
    return max(stored_closeness(sight, covering_texel(sight)) / sight.closeness, 1.0);
}

// The visible share of the part of the light that the sample stands for.
fn filtered_by_cell(sample: u32, receiver: LightReceiver, width: u32, ratio: f32) -> f32 {
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
        let sight = sight_through(sample, receiver, receiver.point + vec3f(step * (ratio - 1.0), 0.0));
        // Only a blocker far enough from the receiver hides that point of the light, and not the sample.
        let share = abs(step) / max(half_cell, vec2f(1e-20));
        let nearest = 1.0 + BLOCKER_SLACK * max(share.x, share.y) * (ratio - 1.0);
        lit += select(0.0, 1.0, sight.possible && (!sight.covered || tap_is_lit(sight, covering_texel(sight), nearest)));
    }
    return lit / f32(CELL_TAPS * CELL_TAPS);
}

// The ratio of the occluder whose silhouette runs between the sample and those around it; 0 where they all see the same.
fn silhouette_ratio(receiver: LightReceiver, tile: u32, tree: u32, lane: u32, row: u32, column: u32, width: u32, is_seen: bool) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let beside = vec2i(vec2u(column, row)) + i32(width) * neighbour(i);
        if any(beside < vec2i(0)) || any(beside >= vec2i(vec2u(shape.columns, shape.sample_rows))) {
            continue;
        }
        let at = vec2u(beside);
        let is_known = bit_of(requests[tree * shape.sample_rows + at.y], at.x) == 1u;
        if !is_known || (bit_of(remembered(tile, at.y, lane), at.x) == 1u) == is_seen {
            continue;
        }
        let hidden = select(vec2u(column, row), at, is_seen);
        let ratio = blocker_ratio(hidden.y * shape.columns + hidden.x, receiver);
        sum += ratio;
        count += select(0.0, 1.0, ratio > 0.0);
    }
    return select(0.0, sum / count, count > 0.0);
}

fn is_before_light(receiver: LightReceiver) -> bool {
    return dot(receiver.normal, receiver.point) < 0.0 && (light.is_one_sided == 0u || receiver.point.z < 0.0);
}

@compute @workgroup_size(TILE, TILE)
fn cs_filter(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let tile = group.y * tiles_across() + group.x;
    let tree = tree_of(tile);
    let pixel = tile_origin(tile) + local.xy;
    let deepest = deepest_drawn();
    var surface: Receiver;
    if all(pixel < frame.size) {
        surface = load_receiver(pixel);
    }
    if lane == 0u {
        atomicStore(&receivers, 0u);
    }
    if lane < MOST_ROWS {
        atomicStore(&seen_by_some[lane], 0u);
        atomicStore(&seen_by_all[lane], 0xffffffffu);
    }
    workgroupBarrier();
    let has_work = surface.is_surface && is_active(tree);
    var is_mixed = false;
    var sees_some = false;
    if has_work {
        atomicAdd(&receivers, 1u);
        var misses_some = false;
        for (var row = 0u; row < shape.sample_rows; row++) {
            let known = requests[tree * shape.sample_rows + row] & known_samples(deepest, row);
            if known != 0u {
                let seen = remembered(tile, row, lane) & known;
                atomicOr(&seen_by_some[row], seen);
                atomicAnd(&seen_by_all[row], seen);
                sees_some |= seen != 0u;
                misses_some |= seen != known;
            }
        }
        is_mixed = sees_some && misses_some;
    }
    workgroupBarrier();
    if lane == 0u {
        count_lookups(tree, atomicLoad(&receivers));
    }
    if any(pixel >= frame.size) {
        return;
    }
    let at = visibility_index(light, pixel, frame.size);
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    if !has_work {
        visibility[at] = select(1.0, 0.0, surface.is_surface && !is_before_light(receiver));
        return;
    }
    if pcf_texels == 0u && !is_mixed {
        visibility[at] = select(0.0, 1.0, sees_some);
        return;
    }
    var visible = 0.0;
    var total = 0.0;
    for (var row = 0u; row < shape.sample_rows; row++) {
        let known = requests[tree * shape.sample_rows + row] & known_samples(deepest, row);
        if known == 0u {
            continue;
        }
        let seen = remembered(tile, row, lane);
        let uncertain = select(select(0u, known, is_mixed), atomicLoad(&seen_by_some[row]) & ~atomicLoad(&seen_by_all[row]), pcf_texels > 0u);
        for (var rest = known; rest != 0u; rest &= rest - 1u) {
            let column = firstTrailingBit(rest);
            let sample = row * shape.columns + column;
            let share = share_of(tree, row, column, deepest);
            var lit = f32(bit_of(seen, column));
            if bit_of(uncertain, column) == 1u {
                if pcf_texels > 0u {
                    lit = filtered_by_pcf(sample, receiver);
                } else {
                    let ratio = silhouette_ratio(receiver, tile, tree, lane, row, column, share.spacing, lit == 1.0);
                    if ratio > 1.0 {
                        lit = filtered_by_cell(sample, receiver, share.spacing, ratio);
                    }
                }
            }
            visible += share.weight * lit;
            total += share.weight;
        }
    }
    visibility[at] = visible / total;
}
