// Percentage-closer soft shadows: the mean distance of the blockers gives the penumbra's width, and that the filter's.

//#include "visibility/maps/shadow_map.wgsl"
//#include "visibility/maps/light_filter.wgsl"
//#include "passes/gbuffer/pixel.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(1) var<storage, read_write> taps: array<vec2f>;           // blocker taps, then filter taps
@group(3) @binding(2) var<storage, read_write> nearest_bits: atomic<u32>;    // the nearest occluder's inverse depth in the map

override blocker_taps: u32;
override filter_taps: u32;

const SEARCH_OCTAVES = 6.0;

// The nearest occluder of the whole map. Positive floats sort like their bits.
@compute @workgroup_size(8, 8)
fn cs_nearest(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(shadow_atlas)) {
        atomicMax(&nearest_bits, bitcast<u32>(textureLoad(shadow_atlas, id.xy, 0)));
    }
}

// The search region suits the map's nearest occluder; half of the taps shrink towards the centre, where the blockers that are
// farther from the light hide it.
fn search_scale(i: u32) -> f32 {
    let shrinking = 2u * i + 1u;
    if shrinking < blocker_taps {
        return 1.0;
    }
    return exp2(-SEARCH_OCTAVES * f32(shrinking - blocker_taps + 1u) / f32(blocker_taps));
}

// [Fernando2005 §blocker search] Mean of the blockers' distance over the receiver's, in a region that the nearest occluder of the
// map could shadow from; negative where there is no blocker.
fn mean_blocker_share(receiver: Receiver, center: MapSample) -> f32 {
    let nearest = bitcast<f32>(atomicLoad(&nearest_bits)) / maps.depth_scale;
    let half_extent = penumbra_half_extent(nearest / center.inverse_depth);
    var sum = 0.0;
    var blockers = 0.0;
    for (var i = 0u; i < blocker_taps; i++) {
        let tap = tap_on_light(i, 0u, blocker_taps) * search_scale(i);
        let map_sample = map_sample_beside(receiver, tap * half_extent);
        if !is_on_light(tap) || !map_sample.covered {
            continue;
        }
        let texel = covering_texel(map_sample);
        if texel_is_lit(map_sample, texel) {
            continue;
        }
        // A blocker farther from the light must be nearer the centre to hide any of it.
        let ratio = stored_inverse_depth(map_sample, texel) / map_sample.inverse_depth;
        if all(abs(tap) * half_extent <= penumbra_half_extent(ratio)) {
            sum += 1.0 / ratio;
            blockers += 1.0;
        }
    }
    return select(-1.0, sum / max(blockers, 1.0), blockers > 0.0);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    let center = project_into_map(0u, receiver, receiver.position_ls);
    if !center.possible || !center.covered {
        visibility[receiver.index] = select(0.0, 1.0, center.possible);
        return;
    }
    var lit = 1.0;
    let blocker_share = mean_blocker_share(receiver, center);
    if blocker_share > 0.0 {
        lit = filter_shadow(receiver, penumbra_half_extent(1.0 / blocker_share), blocker_taps, filter_taps);
    }
    visibility[receiver.index] = lit;
}
