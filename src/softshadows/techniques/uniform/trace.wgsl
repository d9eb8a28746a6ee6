// Uniform light sampling by rays, or by maps where they are certain: the weighted share of the chunk's light samples that each
// receiver sees, added to its visibility. [Schwaerzler2012 Eq. 2]

//#include "visibility/rays/light_rays.wgsl"
//#include "lights/stratified.wgsl"
//#include "visibility/hybrid.wgsl"
//#include "sum.wgsl"

@group(3) @binding(1) var<storage, read_write> report: array<atomic<u32>>;   // not 0: a ray ended before its end

@compute @workgroup_size(8, 8)
fn cs_trace(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    let start = ray_start(receiver);
    var visible_weight = 0.0;
    var unknown = 0u;   // what maps do not know of the chunk, bit by bit: then pixels trace their packets in step
    for (var i = 0u; i < chunk.sample_count; i++) {
        let sample = chunk.first_sample + i;
        let can_be_seen = can_see(start, ray_to(start, light_sample_for(id.xy, sample)));
        let answer = select(HIDDEN, classify_by_map(sample, receiver), can_be_seen);
        visible_weight += select(0.0, light_samples.points[sample].z, answer == LIT);
        unknown |= select(0u, 1u << i, answer == UNKNOWN);
    }
    while unknown != 0u {
        begin_packet(start);
        for (; unknown != 0u && waiting_count < 4u; unknown &= unknown - 1u) {
            let sample = chunk.first_sample + firstTrailingBit(unknown);
            add_to_packet(start, sample, ray_to(start, light_sample_for(id.xy, sample)));
        }
        let is_unoccluded = trace_visibility(packet);
        for (var i = 0u; i < 4u; i++) {
            visible_weight += select(0.0, light_samples.points[waiting[i]].z, is_unoccluded[i]);
        }
    }
    add_chunk(receiver, visible_weight);
    if was_cut_short {
        atomicOr(&report[0], 1u);
    }
}
