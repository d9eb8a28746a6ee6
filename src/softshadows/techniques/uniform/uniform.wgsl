// Uniform light sampling: the weighted share of the chunk's light samples that each receiver sees, added to its visibility.
// [Schwaerzler2012 Eq. 2]

//#include "visibility/maps/shadow_map.wgsl"
//#include "sum.wgsl"

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let pixel = begin_surface(id.xy);
    if !pixel.is_surface {
        return;
    }
    let receiver = light_receiver(pixel.surface.position_ws, pixel.surface.normal_ws);
    var visible_weight = 0.0;
    for (var i = chunk.first_sample; i < chunk_end(); i++) {
        visible_weight += select(0.0, light_samples.points[i].z, sample_is_visible(i, receiver));
    }
    add_chunk(pixel, visible_weight);
}
