// What both ways from look-ups to visibility share: the levels that were drawn, weights, and what is known without look-ups.

//#include "passes/gbuffer/receiver.wgsl"
//#include "tree.wgsl"
//#include "cells.wgsl"
//#include "remembered.wgsl"

@group(3) @binding(4) var<storage, read> masks: array<u32>;               // tree.wgsl mask_index()
@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(7) var<storage, read_write> report: array<atomic<u32>>;

override paper_weights: bool;

// The area of a level's cell, in cells of the deepest level.
fn cell_area(level: u32) -> f32 {
    let side = spacing(level);
    return f32(select(1u, side, shape.has_columns == 1u) * select(1u, side, shape.has_rows == 1u));
}

// [Schwaerzler2012 Eq. 3] 1 / (2^d + 1)² for a sample of a rectangle, 1 / (2^d + 1) on a line; here over that of the deepest level.
fn paper_weight(level: u32) -> f32 {
    let ratio = (exp2(f32(shape.deepest)) + 1.0) / (exp2(f32(level)) + 1.0);
    return select(ratio, ratio * ratio, shape.has_rows == 1u);
}

fn deepest_drawn() -> u32 {
    return shape.deepest - min(control.refused_levels, shape.deepest);
}

// The bits of the samples that the levels down to `level` know, in a row.
fn known_samples(level: u32, row: u32) -> u32 {
    var samples = 0u;
    if row % spacing(level) == 0u {
        for (var column = 0u; column < shape.columns; column += spacing(level)) {
            samples |= 1u << column;
        }
    }
    return samples;
}

fn add_lookups(added: u32) {
    let before = atomicAdd(&report[LOOKUPS_LOW], added);
    if before + added < before {
        atomicAdd(&report[LOOKUPS_HIGH], 1u);
    }
}

// Add the tile's look-ups to the frame's.
fn count_lookups(tree_index: u32, receivers: u32) {
    var samples = 0u;
    for (var row = 0u; row < shape.sample_rows; row++) {
        samples += countOneBits(requests[tree_index * shape.sample_rows + row] & known_samples(deepest_drawn(), row));
    }
    samples += select(0u, 4u, shape.has_probes == 1u && is_active(tree_index));
    add_lookups(samples * receivers);
}

// Add what the light's rays have to tell: for one invocation.
fn report_rays() {
    add_lookups(atomicLoad(&control.bracket_rays));
    atomicOr(&report[CUT_SHORT], atomicLoad(&control.cut_short));
}
