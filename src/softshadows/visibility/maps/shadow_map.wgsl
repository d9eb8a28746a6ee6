// "Is light sample s visible from p?", answered by shadow maps: bind group 2 of every pass that looks into them.

//#include "lights/light_samples.wgsl"
//#include "light_space.wgsl"

@group(2) @binding(2) var<storage, read> shadow_views: array<ShadowView>;    // FACES per sample
@group(2) @binding(3) var shadow_atlas: texture_depth_2d;                    // inverse depth, 0 = nothing
@group(2) @binding(5) var<uniform> maps: MapSettings;

// The view of the light's only sample that holds an atlas texel, as (origin, end); empty outside all of them.
fn view_around(texel: vec2u) -> vec4u {
    for (var i = 0u; i < FACES; i++) {
        let view = shadow_views[i];
        if all(texel >= view.origin) && all(texel < view.origin + view.size) {
            return vec4u(view.origin, view.origin + view.size);
        }
    }
    return vec4u(0u);
}

// A receiver as one light sample sees it: the view that covers it, where in the window, and the receiver's plane.
struct MapSample {
    possible: bool,      // false: below the receiver's horizon, or behind a one-sided light
    view: u32,
    covered: bool,       // false: outside every window, so nothing was drawn that could shadow it
    position: vec2f,     // in the window's plane
    inverse_depth: f32,
    plane_normal: vec3f,
    plane_offset: f32,
};

// Does the view's window hold the point, given in face coordinates?
fn is_covered(view_index: u32, point: vec3f) -> bool {
    let view = shadow_views[view_index];
    let texel = (window_position(point) - view.window_low) * view.texels_per_unit;
    let is_before = light.is_directional == 1u || point.z > 0.0;
    return is_before && all(texel >= vec2f(0.0)) && all(texel < vec2f(view.size));
}

// The receiver as light sample `sample_index` sees it, along the ray through `through`, a point in light space: the
// receiver's own point, or one beside it that a filter wants to know about.
fn project_into_map(sample_index: u32, receiver: Receiver, through: vec3f) -> MapSample {
    let sample_ls = vec3f(light_samples.points[sample_index].xy, 0.0);
    let along = through - sample_ls;
    let from_sample = receiver.position_ls - sample_ls;
    var map_sample: MapSample;
    var toward = dot(receiver.normal_ls, from_sample);
    if light.is_directional == 1u {
        toward = -receiver.normal_ls.z;
    }
    map_sample.possible = toward < 0.0 && is_on_emitting_side(light, receiver);
    // The front window may reach over the other faces. A loop in place of a branch (gpu/driver.wgsl).
    var face = FRONT;
    var point = face_coordinates(FRONT, along);
    map_sample.covered = is_covered(sample_index * FACES + FRONT, point);
    for (var is_beside = !map_sample.covered; is_beside; is_beside = false) {
        face = face_of(along);
        point = face_coordinates(face, along);
        map_sample.covered = face != FRONT && is_covered(sample_index * FACES + face, point);
    }
    map_sample.view = sample_index * FACES + face;
    map_sample.position = window_position(point);
    map_sample.inverse_depth = inverse_depth_of(point.z);
    map_sample.plane_normal = face_coordinates(face, receiver.normal_ls);
    map_sample.plane_offset = dot(receiver.normal_ls, from_sample);
    return map_sample;
}

// How often this invocation has read the map, for techniques that report it; elsewhere a compiler drops it.
var<private> map_reads: u32;

// Inverse depth of the first occluder in a texel of the map sample's view, 0 where there is none.
fn stored_inverse_depth(map_sample: MapSample, texel: vec2u) -> f32 {
    map_reads++;
    return textureLoad(shadow_atlas, shadow_views[map_sample.view].origin + texel, 0) / maps.depth_scale;
}

// How much farther than the stored occluder the receiver may seem and still be lit, in shadow-map texels at the receiver:
// for vertices that the rasteriser snaps to a fraction of a texel, times the receiver's slope; for surfaces that curve
// within a texel; and, where the occluder ends within the texel, for the part of the slope beyond 74 degrees. Then how
// alike the differences on a smooth surface are, and how far an occluder may be to be the receiver's own neighbourhood.
// Measured: docs/decisions/0002-bias.md and 0008-grazing-light.md.
const SNAP_BIAS_TEXELS = 0.1;
const CURVATURE_BIAS_TEXELS = 0.5;
const FLOAT_BIAS = 2e-6;  // of the inverse depth
const GRAZING_BIAS_TEXELS = 1.1;
const GRAZING_SLOPE = 3.5;  // 74 degrees
const GRAZING_SLOPE_LIMIT = 60.0;
const SMOOTH_RATIO = 4.0;
const CREASE_TEXELS = 8.0;

// A texel's occluder against the receiver's plane.
struct TexelGap {
    stored: f32,   // inverse depth of the occluder, 0 where there is none
    texels: f32,   // by how much it is before the plane and the bias, in texels at the receiver; 0 or less: not at all
    grazing: f32,  // how much of that may come from a surface that ends within the texel, in grazing light
};

// What a texel is to the receiver: its extent in the window; how much inverse depth changes over its width, seen along the ray, and
// by how many texels of that the receiver's plane is steep; by how many an occluder may be before the plane.
struct TexelScale {
    extent: vec2f,
    inverse_depth: f32,
    slope: f32,
    bias_texels: f32,
};

fn texel_scale(map_sample: MapSample) -> TexelScale {
    let extent = 1.0 / shadow_views[map_sample.view].texels_per_unit;
    let inverse_depth = inverse_depth_of_extent(map_sample.inverse_depth, max(extent.x, extent.y));
    let slope = inverse_depth_per_texel(map_sample.plane_normal, map_sample.plane_offset, extent) / inverse_depth;
    return TexelScale(extent, inverse_depth, slope, SNAP_BIAS_TEXELS * slope + CURVATURE_BIAS_TEXELS);
}

// By how many texels four occluders lie before the receiver's plane, whose inverse depth is `on_plane` there, and before the bias.
fn gaps(map_sample: MapSample, scale: TexelScale, stored: vec4f, on_plane: vec4f) -> vec4f {
    let bounded = clamp(on_plane, vec4f(0.5 * map_sample.inverse_depth), vec4f(2.0 * map_sample.inverse_depth));
    return (stored - bounded - FLOAT_BIAS * map_sample.inverse_depth) / scale.inverse_depth - scale.bias_texels;
}

// The stored inverse depth belongs to the ray through the texel's centre, so it is compared with the receiver's plane on that
// same ray: a plane never shadows itself, however steep, and the only bias left is for rounding and curvature.
fn texel_gap(map_sample: MapSample, texel: vec2u) -> TexelGap {
    let view = shadow_views[map_sample.view];
    let scale = texel_scale(map_sample);
    let center = view.window_low + (vec2f(texel) + 0.5) * scale.extent;
    let on_plane = plane_inverse_depth(map_sample.plane_normal, map_sample.plane_offset, center);
    let stored = stored_inverse_depth(map_sample, texel);
    let gap = gaps(map_sample, scale, vec4f(stored), vec4f(on_plane)).x;
    let grazing = GRAZING_BIAS_TEXELS * clamp(scale.slope - GRAZING_SLOPE, 0.0, GRAZING_SLOPE_LIMIT);
    return TexelGap(stored, gap, grazing);
}

// Is the receiver's plane lit in this texel? For filters, which ask about many texels around the receiver.
fn texel_is_lit(map_sample: MapSample, texel: vec2u) -> bool {
    let gap = texel_gap(map_sample, texel);
    return gap.texels <= gap.grazing;
}

fn covering_texel(map_sample: MapSample) -> vec2u {
    let view = shadow_views[map_sample.view];
    return vec2u((map_sample.position - view.window_low) * view.texels_per_unit);
}

// Where the receiver lies from its texel's centre, in texels.
fn offset_in_texel(map_sample: MapSample, texel: vec2u) -> vec2f {
    let view = shadow_views[map_sample.view];
    return (map_sample.position - view.window_low) * view.texels_per_unit - (vec2f(texel) + 0.5);
}

// Inverse depth of the texel beside this one, or of the texel itself at the window's border.
fn inverse_depth_beside(map_sample: MapSample, texel: vec2u, step: vec2i) -> f32 {
    let last = vec2i(shadow_views[map_sample.view].size) - 1;
    return stored_inverse_depth(map_sample, vec2u(clamp(vec2i(texel) + step, vec2i(0), last)));
}

// A surface of this inverse depth or less, on the receiver's own ray, does not hide the receiver.
fn free_inverse_depth(map_sample: MapSample) -> f32 {
    let view = shadow_views[map_sample.view];
    let texel_extent = 1.0 / min(view.texels_per_unit.x, view.texels_per_unit.y);
    let bias = CURVATURE_BIAS_TEXELS * inverse_depth_of_extent(map_sample.inverse_depth, texel_extent);
    return map_sample.inverse_depth + bias + FLOAT_BIAS * map_sample.inverse_depth;
}

// How much the occluder's own surface changes in inverse depth along an axis, from the texel's centre to the receiver `offset`
// texels away. Of the differences to the two neighbours the smaller counts: across a silhouette one of them is large and
// means nothing. On a smooth surface they are alike, and the one that puts the surface farther from the light counts.
fn surface_change(map_sample: MapSample, texel: vec2u, here: f32, step: vec2i, offset: f32) -> f32 {
    let before = here - inverse_depth_beside(map_sample, texel, -step);
    let after = inverse_depth_beside(map_sample, texel, step) - here;
    let before_is_smaller = abs(before) < abs(after);
    let smaller = select(after, before, before_is_smaller);
    let larger = select(before, after, before_is_smaller);
    if abs(larger) <= SMOOTH_RATIO * abs(smaller) {
        return min(smaller * offset, larger * offset);
    }
    return smaller * offset;
}

// In a concave crease, or on a curved surface that is seen at a grazing angle, the texel's centre may lie just before the
// receiver's plane though the receiver itself is free. The occluder's own surface tells: where it passes behind the
// receiver, it does not shadow it.
fn occluder_surface_is_behind(map_sample: MapSample, texel: vec2u, here: f32) -> bool {
    let offset = offset_in_texel(map_sample, texel);
    let change_x = surface_change(map_sample, texel, here, vec2i(1, 0), offset.x);
    let change_y = surface_change(map_sample, texel, here, vec2i(0, 1), offset.y);
    return here + change_x + change_y <= free_inverse_depth(map_sample);
}

// Does the occluder end between the texel's centre and the receiver? Then a texel beside this one, on the receiver's side,
// shows what lies behind it: something that is no closer than the receiver.
fn occluder_ends_before(map_sample: MapSample, texel: vec2u) -> bool {
    let side = select(vec2i(-1), vec2i(1), offset_in_texel(map_sample, texel) > vec2f(0.0));
    let beside = min(
        inverse_depth_beside(map_sample, texel, vec2i(side.x, 0)),
        inverse_depth_beside(map_sample, texel, vec2i(0, side.y)),
    );
    return beside <= free_inverse_depth(map_sample);
}

// Is the light sample visible from the receiver that sees it so?
fn map_sample_is_lit(map_sample: MapSample) -> bool {
    if !map_sample.possible || !map_sample.covered {
        return map_sample.possible;
    }
    let texel = covering_texel(map_sample);
    let gap = texel_gap(map_sample, texel);
    // Before the receiver's plane, which may fall steeply towards the texel's centre, but not before the receiver itself.
    if gap.texels <= 0.0 || gap.stored <= free_inverse_depth(map_sample) {
        return true;
    }
    return (gap.texels <= gap.grazing && occluder_ends_before(map_sample, texel))
        || (gap.texels < CREASE_TEXELS && occluder_surface_is_behind(map_sample, texel, gap.stored));
}

// Is light sample `sample_index` visible from the receiver?
fn sample_is_visible(sample_index: u32, receiver: Receiver) -> bool {
    return map_sample_is_lit(project_into_map(sample_index, receiver, receiver.position_ls));
}
