// Number a level's requested samples, share the atlas among their maps, and size the level's dispatches.

//#include "tree.wgsl"
//#include "level.wgsl"

@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(7) var<storage, read_write> report: array<u32>;
@group(3) @binding(8) var<storage, read_write> dispatches: array<vec4u>;   // by level: tiles, then samples

fn needed_samples(row: u32) -> u32 {
    return atomicLoad(&control.needed[row]) & new_samples(row);
}

// How many needed samples come before bit `column` of `row`.
fn rank_of(row: u32, column: u32) -> u32 {
    var rank = countOneBits(needed_samples(row) & ((1u << column) - 1u));
    for (var before = 0u; before < row; before++) {
        rank += countOneBits(needed_samples(before));
    }
    return rank;
}

@compute @workgroup_size(PIXELS)
fn cs_list(@builtin(local_invocation_index) lane: u32) {
    for (var sample = lane; sample < shape.sample_count; sample += PIXELS) {
        let row = sample / shape.columns;
        let column = sample % shape.columns;
        if ((needed_samples(row) >> column) & 1u) == 1u {
            control.ranked[rank_of(row, column)] = sample;
        }
    }
    if lane > 0u {
        return;
    }
    let count = rank_of(shape.sample_rows - 1u, shape.columns);
    let at_one_time = select(min(count, step.samples_per_batch), shape.sample_count, shape.is_resident == 1u);
    let per_row = max(u32(ceil(sqrt(f32(at_one_time)))), 1u);
    control.levels[step.level].sample_count = count;
    control.levels[step.level].tiles_per_row = per_row;
    control.levels[step.level].tile_size = min(shape.largest_tile, shape.atlas_size / per_row);
    report[SHADOW_MAPS] += count;
    let tiles = select(atomicLoad(&control.levels[step.level].active_tiles), 0u, count == 0u);
    dispatches[2u * step.level] = vec4u(min(tiles, GROUPS_PER_ROW), (tiles + GROUPS_PER_ROW - 1u) / GROUPS_PER_ROW, 1u, 0u);
    dispatches[2u * step.level + 1u] = vec4u(count, 1u, 1u, 0u);
}
