// Where is the light sampled too coarsely? At every texel of the comparison, the number of a cell's corners that are visible,
// and whether the texels around it see another number. [Schwaerzler2012 §3.3.3]

//#include "passes/gbuffer/receiver.wgsl"
//#include "tree.wgsl"
//#include "cells.wgsl"
//#include "visibility_bits.wgsl"
//#include "level.wgsl"

@group(3) @binding(4) var<storage, read> visibility_bits: array<u32>;               // tree.wgsl mask_index()
@group(3) @binding(3) var<storage, read_write> failures: array<atomic<u32>>;
@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(7) var<storage, read_write> report: array<atomic<u32>>;
@group(3) @binding(9) var<storage, read_write> counts: array<atomic<u32>>;   // by tree, level, row and cell

// The number of visible corners of each cell in a row, from 0 to 4, as three bits in as many words.
struct Corners {
    ones: u32,
    twos: u32,
    fours: u32,
};

// [Schwaerzler2012 §3.3.3] The first pass: how many of the cells' corners a texel sees.
fn visible_corners(tile: u32, lane: u32, row: u32) -> Corners {
    let rows = sample_rows(step.level, row);
    let low = row_bits(tile, rows.x, lane);
    let high = row_bits(tile, rows.y, lane);
    let shift = right_shift(step.level);
    let low_ones = low ^ (low >> shift);
    let low_twos = low & (low >> shift);
    let high_ones = high ^ (high >> shift);
    let high_twos = high & (high >> shift);
    let carry = low_ones & high_ones;
    return Corners(low_ones ^ high_ones, low_twos ^ high_twos ^ carry, low_twos & high_twos);
}

fn is_surface(pixel: vec2i) -> bool {
    return all(pixel >= vec2i(0)) && all(pixel < vec2i(frame.size)) && textureLoad(g_position, vec2u(pixel), 0).w > 0.0;
}

// The cells of which a texel sees another number of corners, as far as its own tile knows them.
fn differing_cells(here: Corners, pixel: vec2u, row: u32) -> u32 {
    let tile = pixel.y / TILE * tiles_across() + pixel.x / TILE;
    let there = visible_corners(tile, pixel.y % TILE * TILE + pixel.x % TILE, row);
    let differing = (here.ones ^ there.ones) | (here.twos ^ there.twos) | (here.fours ^ there.fours);
    return differing & present_cells(tree_of(tile), step.level, row);
}

// [Schwaerzler2012 §3.3.3] The second pass: cells of which the texel sees a part, and no neighbour another number.
fn failing_cells(pixel: vec2u, tile: u32, lane: u32, row: u32, present: u32) -> u32 {
    let here = visible_corners(tile, lane, row);
    var failing = (here.ones | here.twos) & present;
    if step.level < min(shape.sure_levels, shape.deepest) {
        return failing;
    }
    for (var i = 0u; i < 8u && failing != 0u; i++) {
        let beside = vec2i(pixel) + i32(shape.comparison_step) * neighbour(i);
        // Rays are asked where they help most, so with them only the four nearest texels may excuse a cell.
        let counts = shape.has_probes == 0u || any(neighbour(i) == vec2i(0));
        if counts && is_surface(beside) {
            failing &= ~differing_cells(here, vec2u(beside), row);
        }
    }
    return failing;
}

fn count_failures(tree: u32, row: u32, failing: u32) {
    if shape.threshold > 0u {
        for (var rest = failing; rest != 0u; rest &= rest - 1u) {
            atomicAdd(&counts[count_index(tree, step.level, row, firstTrailingBit(rest))], 1u);
        }
    }
}

@compute @workgroup_size(TILE, TILE)
fn cs_compare(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let list_at = list_index(group);
    if list_at >= atomicLoad(&control.levels[step.level].active_tiles) || any(local.xy % shape.comparison_step != vec2u(0u)) {
        return;
    }
    let tile = control.tile_lists[step.level * tile_count() + list_at];
    let tree = tree_of(tile);
    let pixel = tile_origin(tile) + local.xy;
    if !is_surface(vec2i(pixel)) {
        return;
    }
    let quadrant = local.y / QUADRANT * 2u + local.x / QUADRANT;
    for (var row = 0u; row < cell_rows(step.level); row++) {
        let present = present_cells(tree, step.level, row);
        if present == 0u {
            continue;
        }
        let failing = failing_cells(pixel, tile, lane, row, present);
        if failing == 0u {
            continue;
        }
        if step.level < shape.deepest {
            atomicOr(&failures[failure_index(tree, step.level, row, quadrant)], failing);
            count_failures(tree, row, failing);
        } else {
            if atomicOr(&failures[capped_index(tile)], 1u) == 0u {
                atomicAdd(&report[CAPPED_TILES], 1u);
            }
            break;
        }
    }
}
