// "Is light sample s visible from p?", answered by shadow maps: bind group 2 of every pass that looks into them.

//#include "light_space.wgsl"
//#struct Chunk

@group(2) @binding(0) var<uniform> light: ShadowLight;
@group(2) @binding(1) var<storage, read> light_samples: array<vec4f>;        // x, y in light space, weight, 0
@group(2) @binding(2) var<storage, read> shadow_views: array<ShadowView>;    // FACES per sample
@group(2) @binding(3) var shadow_atlas: texture_depth_2d;                    // closeness, 0 = nothing
@group(2) @binding(4) var<uniform> chunk: Chunk;                             // the samples whose maps the atlas holds

// A receiver's point and geometric normal in light space.
struct LightReceiver {
    point: vec3f,
    normal: vec3f,
};

fn light_receiver(position_ws: vec3f, normal_ws: vec3f) -> LightReceiver {
    return LightReceiver(to_light_space(light, position_ws - light.center_ws), to_light_space(light, normal_ws));
}

// A receiver as one light sample sees it: the view that covers it, where in the window, and the receiver's plane.
struct Sight {
    possible: bool,      // false: below the receiver's horizon, or behind a one-sided light
    view: u32,
    covered: bool,       // false: outside every window, so nothing was drawn that could shadow it
    position: vec2f,     // in the window's plane
    closeness: f32,
    plane_normal: vec3f,
    plane_offset: f32,
};

// The receiver as light sample `sample_index` sees it, along the ray through `through`, a point in light space: the receiver's own
// point, or one beside it that a filter wants to know about.
fn sight_through(sample_index: u32, receiver: LightReceiver, through: vec3f) -> Sight {
    let sample_ls = vec3f(light_samples[sample_index].xy, 0.0);
    let along = through - sample_ls;
    let from_sample = receiver.point - sample_ls;
    var sight: Sight;
    let toward = select(dot(receiver.normal, from_sample), -receiver.normal.z, light.is_directional == 1u);
    sight.possible = toward < 0.0 && (light.is_one_sided == 0u || receiver.point.z < 0.0);
    let face = face_of(light, along);
    sight.view = sample_index * FACES + face;
    let point = face_coordinates(face, along);
    let view = shadow_views[sight.view];
    sight.position = window_position(light, point);
    let texel = (sight.position - view.window_low) * view.texels_per_unit;
    sight.covered = all(texel >= vec2f(0.0)) && all(texel < vec2f(view.size));
    sight.closeness = closeness_of(light, point.z);
    sight.plane_normal = face_coordinates(face, receiver.normal);
    sight.plane_offset = dot(receiver.normal, from_sample);
    return sight;
}

// Closeness of the first occluder in a texel of the sight's view, 0 where there is none.
fn stored_closeness(sight: Sight, texel: vec2u) -> f32 {
    return textureLoad(shadow_atlas, shadow_views[sight.view].origin + texel, 0) / light.depth_scale;
}

// How much farther than the stored occluder the receiver may seem and still be lit, in shadow-map texels at the receiver.
// The first covers vertices that the rasteriser snaps to a fraction of a texel and grows with the receiver's slope, the
// second surfaces that curve within a texel. Measured: docs/decisions/0002-bias.md.
const SNAP_BIAS_TEXELS = 0.1;
const CURVATURE_BIAS_TEXELS = 0.4;
const FLOAT_BIAS = 2e-6;  // of the closeness

// One shadow-map test: is the texel free of occluders before the receiver's plane?
//
// The stored closeness belongs to the ray through the texel's centre, so it is compared with the receiver's plane on that
// same ray: a plane never shadows itself, however steep, and the only bias left is for rounding and curvature.
fn texel_is_lit(sight: Sight, texel: vec2u) -> bool {
    let view = shadow_views[sight.view];
    let stored = stored_closeness(sight, texel);
    let texel_extent = 1.0 / view.texels_per_unit;
    let center = view.window_low + (vec2f(texel) + 0.5) * texel_extent;
    let on_plane = plane_closeness(light, sight.plane_normal, sight.plane_offset, center);
    let bounded = clamp(on_plane, 0.5 * sight.closeness, 2.0 * sight.closeness);
    let snap = SNAP_BIAS_TEXELS * closeness_per_texel(light, sight.plane_normal, sight.plane_offset, texel_extent);
    let curvature = CURVATURE_BIAS_TEXELS * closeness_of_extent(light, sight.closeness, max(texel_extent.x, texel_extent.y));
    return stored <= bounded + light.bias_scale * (snap + curvature) + FLOAT_BIAS * sight.closeness;
}

fn covering_texel(sight: Sight) -> vec2u {
    let view = shadow_views[sight.view];
    return vec2u((sight.position - view.window_low) * view.texels_per_unit);
}

// Is light sample `sample_index` visible from the receiver?
fn sample_is_visible(sample_index: u32, receiver: LightReceiver) -> bool {
    let sight = sight_through(sample_index, receiver, receiver.point);
    if !sight.possible || !sight.covered {
        return sight.possible;
    }
    return texel_is_lit(sight, covering_texel(sight));
}
