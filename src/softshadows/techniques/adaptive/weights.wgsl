// What both ways from look-ups to visibility share: where a pixel begins, weights, and what is known
// without look-ups. The including file declares `light`.

//#needs light
//#include "passes/gbuffer/receiver.wgsl"
//#include "tree.wgsl"
//#include "cells.wgsl"
//#include "visibility_bits.wgsl"

@group(3) @binding(4) var<storage, read> visibility_bits: array<u32>;               // tree.wgsl mask_index()
@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(7) var<storage, read_write> report: array<atomic<u32>>;

override paper_weights: bool;

var<workgroup> receivers: atomic<u32>;

struct TreePixel {
    exists: bool,      // false: outside of the image
    tile: u32,
    tree: u32,
    place: vec2u,      // in the image
    receiver: Receiver,
};

fn tree_pixel(group: vec2u, local: vec2u) -> TreePixel {
    var found: TreePixel;
    found.tile = group.y * tiles_across() + group.x;
    found.tree = tree_of(found.tile);
    found.place = tile_origin(found.tile) + local;
    found.exists = all(found.place < frame.size);
    if found.exists {
        found.receiver = seen_by(light, load_receiver(found.place));
        found.receiver.index = visibility_index(light, found.place, frame.size);
    }
    return found;
}

// How many of the tile's pixels show a surface. For all of its invocations at once.
fn receivers_of_tile(receiver: Receiver, lane: u32) -> u32 {
    if lane == 0u {
        atomicStore(&receivers, 0u);
    }
    workgroupBarrier();
    if receiver.is_surface {
        atomicAdd(&receivers, 1u);
    }
    workgroupBarrier();
    return atomicLoad(&receivers);
}

fn is_before_light(receiver: Receiver) -> bool {
    return dot(receiver.normal_ls, receiver.position_ls) < 0.0 && is_on_emitting_side(light, receiver);
}

// What is known without a tree: nothing is seen from behind the light, nor from a receiver that is turned away.
fn visibility_without_tree(receiver: Receiver) -> f32 {
    return select(1.0, 0.0, receiver.is_surface && !is_before_light(receiver));
}

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
        samples += countOneBits(trees[request_index(tree_index, row)]);
    }
    samples += select(0u, 4u, shape.has_probes == 1u && is_active(tree_index));
    add_lookups(samples * receivers);
}

// Add what the light's rays have to tell: for one invocation.
fn report_rays() {
    add_lookups(atomicLoad(&control.bracket_rays));
    atomicOr(&report[CUT_SHORT], atomicLoad(&control.cut_short));
}
