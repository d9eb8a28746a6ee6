// Percentage-closer filtering: the share of the texels around the receiver's that are lit. [Reeves1987 §3]

//#include "visibility/maps/shadow_map.wgsl"
//#include "visibility/maps/texel_filter.wgsl"
//#include "passes/gbuffer/pixel.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(1) var<storage, read_write> taps: array<vec2f>;  // in half kernels

override tap_count: u32;
override half_kernel_texels: f32;

// [Reeves1987 §3] Compare first, then average.
fn filter_shadow(receiver: Receiver) -> f32 {
    let map_sample = project_into_map(0u, receiver, receiver.position_ls);
    if !map_sample.possible || !map_sample.covered {
        return select(0.0, 1.0, map_sample.possible);
    }
    return lit_share(map_sample, 0u, tap_count, half_kernel_texels);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if receiver.is_surface {
        visibility[receiver.index] = filter_shadow(receiver);
    }
}
