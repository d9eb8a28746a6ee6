// Fit the shadow maps of every light sample to all receivers: one workgroup per sample.

//#include "windows.wgsl"

fn is_receiver(box: u32, sample: u32) -> bool {
    return true;
}

@compute @workgroup_size(LANES)
fn cs_fit_views(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let sample = group.x;
    let in_batch = sample % maps.samples_per_batch;
    let chunk = sample / maps.samples_per_chunk;
    fit_sample(sample, Slot(in_batch, maps.tile_size, maps.tiles_per_row, chunk, maps.texels_per_pixel), lane);
}
