// Uniform light sampling: the weighted share of the chunk's light samples that each receiver sees, added to its visibility.
// [Schwaerzler2012 Eq. 2]

//#include "receiver.wgsl"
//#include "shadow_map.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = light.visibility_offset + id.y * frame.size.x + id.x;
    let surface = load_receiver(id.xy);
    if !surface.is_surface {
        visibility[pixel] = 1.0;
        return;
    }

    // Add this chunk's samples. Weights are small whole numbers, so the sum is exact until it is divided.
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    var visible_weight = select(visibility[pixel], 0.0, chunk.first_sample == 0u);
    let end = chunk.first_sample + chunk.sample_count;
    for (var i = chunk.first_sample; i < end; i++) {
        visible_weight += select(0.0, light_samples[i].z, sample_is_visible(i, receiver));
    }
    let is_last = end == light.sample_count;
    visibility[pixel] = select(visible_weight, visible_weight / light.total_weight, is_last);
}
