// Variance shadow maps: filtered mean and variance of depth bound the share of lit texels by Chebyshev's inequality.
//
// Depth is the distance along the map's axis over the light's reach, from 0 to 1; 1 where nothing was drawn.

//#include "visibility/maps/shadow_map.wgsl"
//#include "passes/gbuffer/pixel.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(1) var<storage, read_write> row_moments: array<vec2f>;  // filtered along rows
@group(3) @binding(2) var<storage, read_write> moments: array<vec2f>;      // and columns: mean depth, mean squared depth

override kernel_radius: i32;
override light_bleed_reduction: f32;
override min_variance: f32;

fn linear_depth(inverse_depth: f32) -> f32 {
    let depth = select(1.0 / (max(inverse_depth, 1e-30) * maps.far), 1.0 - inverse_depth, light.is_directional == 1u);
    return clamp(depth, 0.0, 1.0);
}

fn texel_index(texel: vec2u) -> u32 {
    return texel.y * maps.atlas_size + texel.x;
}

// [Donnelly2006 §3] The two moments of depth, filtered by a box along rows ...
@compute @workgroup_size(8, 8)
fn cs_filter_rows(@builtin(global_invocation_id) id: vec3u) {
    let view = view_around(id.xy);
    if view.z == 0u {
        return;
    }
    var sum = vec2f(0.0);
    for (var i = -kernel_radius; i <= kernel_radius; i++) {
        let x = u32(clamp(i32(id.x) + i, i32(view.x), i32(view.z) - 1));
        let depth = linear_depth(textureLoad(shadow_atlas, vec2u(x, id.y), 0) / maps.depth_scale);
        sum += vec2f(depth, depth * depth);
    }
    row_moments[texel_index(id.xy)] = sum / f32(2 * kernel_radius + 1);
}

// ... and along columns.
@compute @workgroup_size(8, 8)
fn cs_filter_columns(@builtin(global_invocation_id) id: vec3u) {
    let view = view_around(id.xy);
    if view.z == 0u {
        return;
    }
    var sum = vec2f(0.0);
    for (var i = -kernel_radius; i <= kernel_radius; i++) {
        let y = u32(clamp(i32(id.y) + i, i32(view.y), i32(view.w) - 1));
        sum += row_moments[texel_index(vec2u(id.x, y))];
    }
    moments[texel_index(id.xy)] = sum / f32(2 * kernel_radius + 1);
}

fn bilinear_moments(map_sample: MapSample) -> vec2f {
    let view = shadow_views[map_sample.view];
    let corner = clamp((map_sample.position - view.window_low) * view.texels_per_unit - 0.5, vec2f(0.0), vec2f(view.size) - 1.0);
    let low = view.origin + vec2u(corner);
    let high = min(low + 1u, view.origin + view.size - 1u);
    let weight = fract(corner);
    return mix(
        mix(moments[texel_index(low)], moments[texel_index(vec2u(high.x, low.y))], weight.x),
        mix(moments[texel_index(vec2u(low.x, high.y))], moments[texel_index(high)], weight.x),
        weight.y,
    );
}

// [Donnelly2006 Eq. 5] Chebyshev's upper bound, with Lauritzen's cut of its tail against light bleeding.
fn upper_bound(mean_depth: vec2f, depth: f32) -> f32 {
    let variance = max(mean_depth.y - mean_depth.x * mean_depth.x, min_variance);
    let beyond = depth - mean_depth.x;
    if beyond <= 0.0 {
        return 1.0;
    }
    let bound = variance / (variance + beyond * beyond);
    return clamp((bound - light_bleed_reduction) / (1.0 - light_bleed_reduction), 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    let map_sample = project_into_map(0u, receiver, receiver.position_ls);
    var lit = select(0.0, 1.0, map_sample.possible);
    if map_sample.possible && map_sample.covered {
        lit = upper_bound(bilinear_moments(map_sample), linear_depth(map_sample.inverse_depth));
    }
    visibility[receiver.index] = lit;
}
