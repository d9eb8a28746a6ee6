// Uniform light sampling by rays, or by maps where they are certain: the weighted share of the chunk's light samples that each
// receiver sees, added to its visibility. [Schwaerzler2012 Eq. 2]

//#include "receiver.wgsl"
//#include "light_rays.wgsl"
//#include "known_by_map.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(1) var<storage, read_write> report: array<atomic<u32>>;   // not 0: a ray ended before its end

var<private> visible_weight: f32;

fn trace_packet() {
    let is_open = open_segments(packet);
    for (var i = 0u; i < 4u; i++) {
        visible_weight += select(0.0, light_samples[waiting[i]].z, is_open[i]);
    }
}

@compute @workgroup_size(8, 8)
fn cs_trace(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = light.visibility_offset + id.y * frame.size.x + id.x;
    let surface = load_receiver(id.xy);
    if !surface.is_surface {
        visibility[pixel] = 1.0;
        return;
    }

    // Ask about this chunk's samples. Weights are small whole numbers, so the sum is exact until it is divided.
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    let start = ray_start(surface.position_ws, surface.normal_ws);
    let end = chunk.first_sample + chunk.sample_count;
    begin_packet(start);
    for (var i = chunk.first_sample; i < end; i++) {
        let ray = ray_to(start, light_samples[i].xy);
        let answer = select(HIDDEN, map_answer(i, receiver), can_see(start, ray));
        visible_weight += select(0.0, light_samples[i].z, answer == LIT);
        if answer == UNKNOWN {
            add_to_packet(start, i, ray);
        }
        if waiting_count == 4u {
            trace_packet();
            begin_packet(start);
        }
    }
    if waiting_count > 0u {
        trace_packet();
    }

    let sum = visible_weight + select(visibility[pixel], 0.0, chunk.first_sample == 0u);
    visibility[pixel] = select(sum, sum / light.total_weight, end == light.sample_count);
    if was_cut_short {
        atomicOr(&report[0], 1u);
    }
}
