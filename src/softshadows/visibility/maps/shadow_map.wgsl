// "Is light sample s visible from p?", answered by shadow maps: bind group 2 of every pass that looks into them.

//#include "lights/light_samples.wgsl"
//#include "light_space.wgsl"

@group(2) @binding(2) var<storage, read> shadow_views: array<ShadowView>;    // FACES per sample
@group(2) @binding(3) var shadow_atlas: texture_depth_2d;                    // closeness, 0 = nothing
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
struct Sight {
    possible: bool,      // false: below the receiver's horizon, or behind a one-sided light
    view: u32,
    covered: bool,       // false: outside every window, so nothing was drawn that could shadow it
    position: vec2f,     // in the window's plane
    closeness: f32,
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
fn sight_through(sample_index: u32, receiver: Receiver, through: vec3f) -> Sight {
    let sample_ls = vec3f(light_samples.points[sample_index].xy, 0.0);
    let along = through - sample_ls;
    let from_sample = receiver.position_ls - sample_ls;
    var sight: Sight;
    var toward = dot(receiver.normal_ls, from_sample);
    if light.is_directional == 1u {
        toward = -receiver.normal_ls.z;
    }
    sight.possible = toward < 0.0 && is_on_emitting_side(light, receiver);
    // The front window may reach over the other faces. A loop in place of a branch (gpu/driver.wgsl).
    var face = FRONT;
    var point = face_coordinates(FRONT, along);
    sight.covered = is_covered(sample_index * FACES + FRONT, point);
    for (var is_beside = !sight.covered; is_beside; is_beside = false) {
        face = face_of(along);
        point = face_coordinates(face, along);
        sight.covered = face != FRONT && is_covered(sample_index * FACES + face, point);
    }
    sight.view = sample_index * FACES + face;
    sight.position = window_position(point);
    sight.closeness = closeness_of(point.z);
    sight.plane_normal = face_coordinates(face, receiver.normal_ls);
    sight.plane_offset = dot(receiver.normal_ls, from_sample);
    return sight;
}

// How often this invocation has read the map, for techniques that report it; elsewhere a compiler drops it.
var<private> map_reads: u32;

// Closeness of the first occluder in a texel of the sight's view, 0 where there is none.
fn stored_closeness(sight: Sight, texel: vec2u) -> f32 {
    map_reads++;
    return textureLoad(shadow_atlas, shadow_views[sight.view].origin + texel, 0) / maps.depth_scale;
}

// How much farther than the stored occluder the receiver may seem and still be lit, in shadow-map texels at the receiver:
// for vertices that the rasteriser snaps to a fraction of a texel, times the receiver's slope; for surfaces that curve
// within a texel; and, where the occluder ends within the texel, for the part of the slope beyond 74 degrees. Then how
// alike the differences on a smooth surface are, and how far an occluder may be to be the receiver's own neighbourhood.
// Measured: docs/decisions/0002-bias.md and 0008-grazing-light.md.
const SNAP_BIAS_TEXELS = 0.1;
const CURVATURE_BIAS_TEXELS = 0.5;
const FLOAT_BIAS = 2e-6;  // of the closeness
const GRAZING_BIAS_TEXELS = 1.1;
const GRAZING_SLOPE = 3.5;  // 74 degrees
const GRAZING_SLOPE_LIMIT = 60.0;
const SMOOTH_RATIO = 4.0;
const CREASE_TEXELS = 8.0;

// A texel's occluder against the receiver's plane.
struct TexelGap {
    stored: f32,   // closeness of the occluder, 0 where there is none
    texels: f32,   // by how much it is before the plane and the bias, in texels at the receiver; 0 or less: not at all
    grazing: f32,  // how much of that may come from a surface that ends within the texel, in grazing light
};

// What a texel is to the receiver: its extent in the window; how much closeness changes over its width, seen along the ray, and
// by how many texels of that the receiver's plane is steep; by how many an occluder may be before the plane.
struct TexelScale {
    extent: vec2f,
    closeness: f32,
    slope: f32,
    bias_texels: f32,
};

fn texel_scale(sight: Sight) -> TexelScale {
    let extent = 1.0 / shadow_views[sight.view].texels_per_unit;
    let closeness = closeness_of_extent(sight.closeness, max(extent.x, extent.y));
    let slope = closeness_per_texel(sight.plane_normal, sight.plane_offset, extent) / closeness;
    return TexelScale(extent, closeness, slope, SNAP_BIAS_TEXELS * slope + CURVATURE_BIAS_TEXELS);
}

// By how many texels four occluders lie before the receiver's plane, whose closeness is `on_plane` there, and before the bias.
fn gaps(sight: Sight, scale: TexelScale, stored: vec4f, on_plane: vec4f) -> vec4f {
    let bounded = clamp(on_plane, vec4f(0.5 * sight.closeness), vec4f(2.0 * sight.closeness));
    return (stored - bounded - FLOAT_BIAS * sight.closeness) / scale.closeness - scale.bias_texels;
}

// The stored closeness belongs to the ray through the texel's centre, so it is compared with the receiver's plane on that
// same ray: a plane never shadows itself, however steep, and the only bias left is for rounding and curvature.
fn texel_gap(sight: Sight, texel: vec2u) -> TexelGap {
    let view = shadow_views[sight.view];
    let scale = texel_scale(sight);
    let center = view.window_low + (vec2f(texel) + 0.5) * scale.extent;
    let on_plane = plane_closeness(sight.plane_normal, sight.plane_offset, center);
    let stored = stored_closeness(sight, texel);
    let gap = gaps(sight, scale, vec4f(stored), vec4f(on_plane)).x;
    let grazing = GRAZING_BIAS_TEXELS * clamp(scale.slope - GRAZING_SLOPE, 0.0, GRAZING_SLOPE_LIMIT);
    return TexelGap(stored, gap, grazing);
}

// Is the receiver's plane lit in this texel? For filters, which ask about many texels around the receiver.
fn texel_is_lit(sight: Sight, texel: vec2u) -> bool {
    let gap = texel_gap(sight, texel);
    return gap.texels <= gap.grazing;
}

fn covering_texel(sight: Sight) -> vec2u {
    let view = shadow_views[sight.view];
    return vec2u((sight.position - view.window_low) * view.texels_per_unit);
}

// Where the receiver lies from its texel's centre, in texels.
fn offset_in_texel(sight: Sight, texel: vec2u) -> vec2f {
    let view = shadow_views[sight.view];
    return (sight.position - view.window_low) * view.texels_per_unit - (vec2f(texel) + 0.5);
}

// Closeness of the texel beside this one, or of the texel itself at the window's border.
fn closeness_beside(sight: Sight, texel: vec2u, step: vec2i) -> f32 {
    let last = vec2i(shadow_views[sight.view].size) - 1;
    return stored_closeness(sight, vec2u(clamp(vec2i(texel) + step, vec2i(0), last)));
}

// A surface of this closeness or less, on the receiver's own ray, does not hide the receiver.
fn free_closeness(sight: Sight) -> f32 {
    let view = shadow_views[sight.view];
    let texel_extent = 1.0 / min(view.texels_per_unit.x, view.texels_per_unit.y);
    let bias = CURVATURE_BIAS_TEXELS * closeness_of_extent(sight.closeness, texel_extent);
    return sight.closeness + bias + FLOAT_BIAS * sight.closeness;
}

// How much the occluder's own surface changes in closeness along an axis, from the texel's centre to the receiver `offset`
// texels away. Of the differences to the two neighbours the smaller counts: across a silhouette one of them is large and
// means nothing. On a smooth surface they are alike, and the one that puts the surface farther from the light counts.
fn surface_change(sight: Sight, texel: vec2u, here: f32, step: vec2i, offset: f32) -> f32 {
    let before = here - closeness_beside(sight, texel, -step);
    let after = closeness_beside(sight, texel, step) - here;
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
fn occluder_surface_is_behind(sight: Sight, texel: vec2u, here: f32) -> bool {
    let offset = offset_in_texel(sight, texel);
    let change_x = surface_change(sight, texel, here, vec2i(1, 0), offset.x);
    let change_y = surface_change(sight, texel, here, vec2i(0, 1), offset.y);
    return here + change_x + change_y <= free_closeness(sight);
}

// Does the occluder end between the texel's centre and the receiver? Then a texel beside this one, on the receiver's side,
// shows what lies behind it: something that is no closer than the receiver.
fn occluder_ends_before(sight: Sight, texel: vec2u) -> bool {
    let side = select(vec2i(-1), vec2i(1), offset_in_texel(sight, texel) > vec2f(0.0));
    let beside = min(
        closeness_beside(sight, texel, vec2i(side.x, 0)),
        closeness_beside(sight, texel, vec2i(0, side.y)),
    );
    return beside <= free_closeness(sight);
}

// Is the light sample visible from the receiver that sees it so?
fn sight_is_lit(sight: Sight) -> bool {
    if !sight.possible || !sight.covered {
        return sight.possible;
    }
    let texel = covering_texel(sight);
    let gap = texel_gap(sight, texel);
    // Before the receiver's plane, which may fall steeply towards the texel's centre, but not before the receiver itself.
    if gap.texels <= 0.0 || gap.stored <= free_closeness(sight) {
        return true;
    }
    return (gap.texels <= gap.grazing && occluder_ends_before(sight, texel))
        || (gap.texels < CREASE_TEXELS && occluder_surface_is_behind(sight, texel, gap.stored));
}

// Is light sample `sample_index` visible from the receiver?
fn sample_is_visible(sample_index: u32, receiver: Receiver) -> bool {
    return sight_is_lit(sight_through(sample_index, receiver, receiver.position_ls));
}
