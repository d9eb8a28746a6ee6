// Start every tile's tree: the root cell, and the tile in the first level's list where its pixels have something to find out.

//#include "passes/gbuffer/receiver.wgsl"
//#include "lights/light.wgsl"
//#include "tree.wgsl"
//#struct ReceiverBox

@group(3) @binding(1) var<storage, read_write> trees: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;
@group(2) @binding(0) var<storage, read> light: Light;
@group(2) @binding(1) var<storage, read> receiver_boxes: array<ReceiverBox>;

var<workgroup> undecided: atomic<u32>;

// No light arrives, or all of it: the receiver is turned away, or nothing can shadow its surroundings.
fn is_decided(pixel: vec2u) -> bool {
    if any(pixel >= frame.size) {
        return true;
    }
    let receiver = seen_by(light, load_receiver(pixel));
    if !receiver.is_surface || shape.is_global == 1u {
        return !receiver.is_surface;
    }
    let heights = heights_of(light, receiver);
    let tile = pixel.y / TILE * tiles_across() + pixel.x / TILE;  // whose pixels are those of one box
    return !is_on_emitting_side(light, receiver) || heights.y <= 0.0 || (heights.x > 0.0 && receiver_boxes[tile].count == 0.0);
}

// The samples at the light's corners, in a row of samples.
fn root_samples(row: u32) -> u32 {
    let in_row = 1u | (1u << right_shift(0u));
    return select(0u, in_row, row % spacing(0u) == 0u);
}

@compute @workgroup_size(TILE, TILE)
fn cs_begin(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let tile = group.y * tiles_across() + group.x;
    let tree = tree_of(tile);
    if lane == 0u {
        atomicStore(&undecided, 0u);  // wgpu does not clear workgroup memory, though WebGPU says so
    }
    workgroupBarrier();
    if !is_decided(tile_origin(tile) + local.xy) {
        atomicStore(&undecided, 1u);
    }
    workgroupBarrier();
    let has_work = atomicLoad(&undecided) == 1u;
    if shape.is_global == 0u || tile == 0u {
        if lane < shape.sample_rows {
            trees[request_index(tree, lane)] = select(0u, root_samples(lane), has_work || shape.is_global == 1u);
        }
        if lane < shape.refined_rows {
            trees[refined_index(tree, 0u, lane)] = 0u;
        }
    }
    if has_work && lane == 0u {
        control.tile_lists[atomicAdd(&control.levels[0].active_tiles, 1u)] = tile;
    }
    if has_work && lane < shape.sample_rows {
        atomicOr(&control.needed[lane], root_samples(lane));
    }
}
