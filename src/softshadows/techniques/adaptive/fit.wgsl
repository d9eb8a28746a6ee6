// Fit the maps of a level's samples to the receivers of the trees that request them: one workgroup per sample.

//#include "visibility/maps/windows.wgsl"
//#include "tree.wgsl"
//#include "level.wgsl"

@group(3) @binding(1) var<storage, read> trees: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;

// A tile's pixels are those of one box.
fn is_receiver(tile: u32, sample: u32) -> bool {
    return ((trees[request_index(tree_of(tile), sample / shape.columns)] >> (sample % shape.columns)) & 1u) == 1u;
}

@compute @workgroup_size(LANES)
fn cs_fit(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let rank = group.x;
    let sample = control.ranked[rank];
    let in_batch = select(rank % step.samples_per_batch, sample, shape.is_resident == 1u);
    let tile_size = control.levels[step.level].tile_size;
    let tiles_per_row = control.levels[step.level].tiles_per_row;
    let chunk = step.first_chunk + rank / step.samples_per_batch;
    fit_sample(sample, Slot(in_batch, tile_size, tiles_per_row, chunk, step.fineness * maps.texels_per_pixel), lane);
}
