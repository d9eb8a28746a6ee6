// Uniform light sampling: the weighted share of the chunk's light samples that each receiver sees, added to its visibility.
// [Schwaerzler2012 Eq. 2]

//#include "visibility/maps/shadow_map.wgsl"
//#include "sum.wgsl"

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    var visible_weight = 0.0;
    for (var i = chunk.first_sample; i < chunk_end(); i++) {
        visible_weight += select(0.0, light_samples.points[i].z, sample_is_visible(i, receiver));
    }
    add_chunk(receiver, visible_weight);
}
