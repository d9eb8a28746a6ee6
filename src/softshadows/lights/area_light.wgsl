// Light that reaches a point from a whole light, unshadowed, and what a glTF metallic-roughness surface reflects of it.
//
// Diffuse is exact, with the light cut at the receiver's horizon: rectangles by Lambert's polygon formula (Baum et al.
// 1989), disks by the same boundary integral along the circle, lines by the integral over the angle they subtend.
// In float32 the relative error is below 5e-7 divided by the angle in radians that the light subtends.
// Specular is GGX with height-correlated Smith masking and Schlick's Fresnel. Points, spots and directional lights
// evaluate it; rectangles and disks use linearly transformed cosines (Heitz et al. 2016), lines their form for lines
// (Heitz and Hill 2017), with the table that benchmarks/fit_ltc.py fits. A disk's highlight is that of a 16-gon
// of its area.
//
// Lengths in metres, emission in the units of scene/lights.py, "lobe space" is a cosine lobe's own frame with z up.

//#include "light.wgsl"

const RECT = 0u;
const DISK = 1u;
const LINE = 2u;
const POINT = 3u;
const SPOT = 4u;
const DIRECTIONAL = 5u;

const PI = 3.14159265;
const DIELECTRIC_REFLECTANCE = 0.04;  // at normal incidence, index of refraction 1.5: glTF 2.0, appendix B
const MIN_ROUGHNESS = 0.045;          // as in benchmarks/fit_ltc.py: below it α⁴ leaves float32's comfortable range
const MIN_VIEW_COSINE = 1e-3;         // the table's grazing row; shading normals can even face away from the viewer
const DISK_CORNERS = 16u;
const DISK_CORNER_RADIUS = 1.01300156;  // sqrt(2π / (16 sin(2π / 16))): the 16-gon has the disk's area
const MIN_SPOT_FALLOFF = 0.001;        // KHR_lights_punctual: least difference of the two cosines
const TINY = 1e-30;                    // keeps 0 / 0 at 0

struct Surface {
    position_ws: vec3f,
    normal_ws: vec3f,            // of shading
    geometric_normal_ws: vec3f,  // faces the viewer
    view_ws: vec3f,              // unit, towards the eye
    base_color: vec3f,           // linear
    metallic: f32,
    roughness: f32,              // perceptual, 0..1
};

// What a surface reflects towards the viewer, prepared once for all lights.
struct Lobes {
    to_surface: mat3x3f,    // world to (tangent towards the viewer, bitangent, shading normal)
    to_lobe: mat3x3f,       // from there to the space in which the specular lobe is a clamped cosine
    above_horizon: f32,     // share of that cosine that lies above the surface
    specular_albedo: vec3f,
    diffuse_albedo: vec3f,
    reflectance: vec3f,     // Fresnel at normal incidence
};

// -- Angles -----------------------------------------------------------------------------------------------------------

// Θ / sin Θ - 1 for 0 ≤ Θ < π. A least-squares fit in 1 - cos Θ on 0..π/2, relative error of the ratio below 2e-7.
fn angle_excess(cosine: f32, sine: f32) -> f32 {
    let y = 1.0 - min(abs(cosine), 1.0);
    let excess = y * (0.333333428 + y * (0.133325029 + y * (0.057318703 + y * (0.023834125 + y * (0.018691399
        + y * (-0.013031272 + y * (0.029515536 + y * (-0.02054973 + y * 0.008358974))))))));
    return select(PI / max(sine, TINY) - excess - 2.0, excess, cosine >= 0.0);
}

// atan(x) / x, to more digits than WGSL asks of atan
fn arctangent_ratio(x: f32) -> f32 {
    let cosine = inverseSqrt(1.0 + x * x);
    return cosine * (1.0 + angle_excess(cosine, abs(x) * cosine));
}

// log(1 + y) / y, for small y by the series of 2 artanh(y / (2 + y))
fn logarithm_ratio(y: f32) -> f32 {
    let z = y / (2.0 + y);
    let series = 1.0 + z * z * (1.0 / 3.0 + z * z * (1.0 / 5.0 + z * z * (1.0 / 7.0 + z * z / 9.0)));
    return select(log(1.0 + y) / y, 2.0 / (2.0 + y) * series, abs(z) < 0.15);
}

// Columns tangent (towards `toward`, where that is not the normal itself), bitangent, normal; all in world space.
fn basis_ws(normal: vec3f, toward: vec3f) -> mat3x3f {
    var tangent = toward - normal * dot(normal, toward);
    if dot(tangent, tangent) < 1e-8 {
        tangent = cross(normal, select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.5));
    }
    tangent = normalize(tangent);
    return mat3x3f(tangent, cross(normal, tangent), normal);
}

// -- Polygons: irradiance of the plane z = 0 by an outline seen from the origin, for radiance 1 ----------------------

// An outline that is being cut at the horizon, and the sum over the edges so far. The parts are convex, so they leave
// and enter the upper half space at most once.
struct Outline {
    irradiance: f32,
    leaves: vec3f,
    enters: vec3f,
};

fn horizon_point(a: vec3f, b: vec3f) -> vec3f {
    return vec3f((a.xy * b.z - b.xy * a.z) / (b.z - a.z), 0.0);
}

// Lambert's term of one edge: half its angle times the height of the unit normal of its plane through the origin.
fn edge_irradiance(a: vec3f, b: vec3f) -> f32 {
    let scale = 1.0 / max(length(a) * length(b), TINY);
    let normal = cross(a, b - a) * scale;  // as cross(a, b), but short edges keep their digits
    return 0.5 * normal.z * (1.0 + angle_excess(dot(a, b) * scale, length(normal)));
}

fn add_edge(outline: ptr<function, Outline>, a: vec3f, b: vec3f) {
    if a.z <= 0.0 && b.z <= 0.0 {
        return;
    }
    var start = a;
    var end = b;
    if a.z <= 0.0 {
        start = horizon_point(a, b);
        (*outline).enters = start;
    }
    if b.z <= 0.0 {
        end = horizon_point(a, b);
        (*outline).leaves = end;
    }
    (*outline).irradiance += edge_irradiance(start, end);
}

// Irradiance of the closed outline; its sign is that of the winding.
fn close_outline(outline: Outline) -> f32 {
    return outline.irradiance + edge_irradiance(outline.leaves, outline.enters);
}

// An outline cut at the surface's horizon and then, transformed, at the lobe's.
struct LobeOutline {
    leaves: vec3f,  // surface space
    enters: vec3f,
    lobe: Outline,  // lobe space
};

fn add_lobe_edge(outline: ptr<function, LobeOutline>, to_lobe: mat3x3f, a: vec3f, b: vec3f) {
    if a.z <= 0.0 && b.z <= 0.0 {
        return;
    }
    var start = a;
    var end = b;
    if a.z <= 0.0 {
        start = horizon_point(a, b);
        (*outline).enters = start;
    }
    if b.z <= 0.0 {
        end = horizon_point(a, b);
        (*outline).leaves = end;
    }
    var lobe = (*outline).lobe;
    add_edge(&lobe, to_lobe * start, to_lobe * end);
    (*outline).lobe = lobe;
}

fn close_lobe_outline(outline: LobeOutline, to_lobe: mat3x3f) -> f32 {
    var lobe = outline.lobe;
    add_edge(&lobe, to_lobe * outline.leaves, to_lobe * outline.enters);
    return close_outline(lobe);
}

fn outline_corner(kind: u32, center: vec3f, right: vec3f, up: vec3f, index: u32) -> vec3f {
    if kind == DISK {
        return disk_corner(center, right, up, index);
    }
    return rect_corner(center, right, up, index % 4u);
}

// Corner `index` of the rectangle ±right ±up around the centre.
fn rect_corner(center: vec3f, right: vec3f, up: vec3f, index: u32) -> vec3f {
    let x = select(-1.0, 1.0, index == 1u || index == 2u);
    return center + x * right + select(-1.0, 1.0, index >= 2u) * up;
}

fn disk_corner(center: vec3f, right: vec3f, up: vec3f, index: u32) -> vec3f {
    let angle = 2.0 * PI * f32(index % DISK_CORNERS) / f32(DISK_CORNERS);
    return center + DISK_CORNER_RADIUS * (cos(angle) * right + sin(angle) * up);
}

fn rect_irradiance(center: vec3f, right: vec3f, up: vec3f) -> f32 {
    var outline = Outline();
    for (var i = 0u; i < 4u; i++) {
        add_edge(&outline, rect_corner(center, right, up, i), rect_corner(center, right, up, (i + 1u) % 4u));
    }
    return abs(close_outline(outline));
}

// -- Disks ------------------------------------------------------------------------------------------------------------

// Lambert's boundary integral ½ ∮ (r × dr)_z / r² along r = center + right cos ψ + up sin ψ; right and up are as long
// as the radius. With up turned square to the centre, r² = P + Q cos ψ and (r × dr)_z = (A + B cos ψ + C sin ψ) dψ.
fn disk_irradiance(center: vec3f, right: vec3f, up: vec3f) -> f32 {
    let radius = length(right);
    if radius * radius < TINY {
        return 0.0;
    }
    let aside = vec2f(dot(center, right), dot(center, up));
    let aside_length = length(aside);
    // Turn the axes so that `outward` points away from the foot of the perpendicular from the origin.
    let turn = select(vec2f(1.0, 0.0), aside / aside_length, aside_length > TINY);
    let outward = turn.x * right + turn.y * up;
    let across = turn.x * up - turn.y * right;

    let offset = aside_length / radius;
    let height = dot(center, cross(right, up)) / (radius * radius);
    let far_squared = height * height + (offset + radius) * (offset + radius);   // P + Q
    let near_squared = height * height + (offset - radius) * (offset - radius);  // P - Q
    let p = 0.5 * (far_squared + near_squared);
    let q = 2.0 * aside_length;
    let s = max(sqrt(far_squared * near_squared), TINY);  // sqrt(P² - Q²)
    let a = cross(outward, across).z;
    let b = cross(center, across).z;
    let c = -cross(center, outward).z;
    let per_angle = a / s - b * q / (s * (s + p));

    // A disk wholly above the horizon has its whole circle for an outline.
    let drop = length(vec2f(outward.z, across.z));
    if center.z >= drop {
        return abs(PI * per_angle);
    }
    if center.z <= -drop {
        return 0.0;
    }

    // Otherwise the outline is an arc and the chord that the horizon cuts.
    let uphill = vec2f(outward.z, across.z) / drop;
    let toward = -center.z / drop;  // cosine of half the arc
    let aslant = sqrt((1.0 - toward) * (1.0 + toward));
    let half_arc = aslant * (1.0 + angle_excess(toward, aslant));
    let start = toward * uphill + aslant * vec2f(uphill.y, -uphill.x);
    let end = toward * uphill + aslant * vec2f(-uphill.y, uphill.x);
    let eccentricity = q / (p + s);
    let odd = disk_arc_term(end, eccentricity) - disk_arc_term(start, eccentricity);
    let start_squared = p + q * start.x;
    let rise = (end.x - start.x) / start_squared;
    let arc = 2.0 * half_arc * per_angle + odd * (2.0 * b * p / (s * (p + s)) - 2.0 * a * eccentricity / s)
        - c * rise * logarithm_ratio(q * rise);
    let start_point = center + start.x * outward + start.y * across;
    let end_point = center + end.x * outward + end.y * across;
    return abs(0.5 * arc + edge_irradiance(vec3f(end_point.xy, 0.0), vec3f(start_point.xy, 0.0)));
}

// atan(e sin ψ / (1 + e cos ψ)) / e for direction (cos ψ, sin ψ): ∫ dψ / (P + Q cos ψ) = ψ / S - 2 e / S times this.
fn disk_arc_term(direction: vec2f, eccentricity: f32) -> f32 {
    let slope = direction.y / (1.0 + eccentricity * direction.x);
    return slope * arctangent_ratio(eccentricity * slope);
}

// -- Lines ------------------------------------------------------------------------------------------------------------

// Irradiance of the plane z = 0 by the segment a to b, which emits sin(angle to its axis) per metre. With the angle φ
// around the origin, from the foot of the perpendicular on the segment's line, and the distance d of that foot:
// 1 / d² ∫ cos φ (foot_z cos φ + d axis_z sin φ) dφ.
fn line_irradiance(a: vec3f, b: vec3f) -> f32 {
    if a.z <= 0.0 && b.z <= 0.0 {
        return 0.0;
    }
    var start = a;
    var end = b;
    if a.z <= 0.0 {
        start = horizon_point(a, b);
    }
    if b.z <= 0.0 {
        end = horizon_point(a, b);
    }
    let span = end - start;
    let span_length = length(span);
    let axis = span / max(span_length, TINY);
    let start_distance = length(start);
    let end_distance = length(end);
    let along_start = dot(start, axis);
    let along_end = dot(end, axis);
    let foot = select(end - along_end * axis, start - along_start * axis, start_distance < end_distance);
    let d = length(foot);
    if d <= 1e-6 * min(start_distance, end_distance) {
        return 0.0;  // seen end on
    }
    let scale = 1.0 / (start_distance * end_distance);
    let sine = d * span_length * scale;
    let cosine = (d * d + along_start * along_end) * scale;
    let sum_sine = d * (along_start + along_end) * scale;
    let sum_cosine = (d * d - along_start * along_end) * scale;
    let one_plus_sum_cosine = select(sum_sine * sum_sine / (1.0 - sum_cosine), 1.0 + sum_cosine, sum_cosine >= 0.0);
    let bracket = foot.z * (angle_excess(cosine, sine) + one_plus_sum_cosine) + d * axis.z * sum_sine;
    return max(0.5 * sine / (d * d) * bracket, 0.0);
}

// The same for a lobe: the transform stretches the line's width, Heitz and Hill 2017, section 3.
fn line_lobe_irradiance(to_lobe: mat3x3f, a: vec3f, b: vec3f) -> f32 {
    if a.z <= 0.0 && b.z <= 0.0 {
        return 0.0;
    }
    var start = a;
    var end = b;
    if a.z <= 0.0 {
        start = horizon_point(a, b);
    }
    if b.z <= 0.0 {
        end = horizon_point(a, b);
    }
    let lobe_start = to_lobe * start;
    let lobe_end = to_lobe * end;
    let plane = length(cross(start, end - start));
    let lobe_plane = length(cross(lobe_start, lobe_end - lobe_start));
    let width = determinant(to_lobe) * plane / max(lobe_plane, TINY);
    return width * line_irradiance(lobe_start, lobe_end);
}

// -- Lights -----------------------------------------------------------------------------------------------------------

fn is_punctual(light: Light) -> bool {
    return light.kind >= POINT;
}

// False behind a one-sided rectangle or disk.
fn emits_toward(light: Light, position_ws: vec3f) -> bool {
    return light.is_one_sided == 0u || dot(light.back_ws, position_ws - light.center_ws) < 0.0;
}

// Unit direction to a light without size, and its irradiance of a surface that faces it, per unit emission.
fn punctual_light(light: Light, position_ws: vec3f) -> vec4f {
    if light.kind == DIRECTIONAL {
        return vec4f(light.back_ws, 1.0);
    }
    let to_light_ws = light.center_ws - position_ws;
    let squared = max(dot(to_light_ws, to_light_ws), TINY);
    let direction_ws = to_light_ws * inverseSqrt(squared);
    var irradiance = 1.0 / squared;
    if light.kind == SPOT {
        // KHR_lights_punctual, "inner and outer cone angles"
        let falloff = max(light.cos_inner - light.cos_outer, MIN_SPOT_FALLOFF);
        let inside = saturate((dot(light.back_ws, direction_ws) - light.cos_outer) / falloff);
        irradiance *= inside * inside;
    }
    return vec4f(direction_ws, irradiance);
}

// Irradiance (W/m²) of a surface for emission 1; the part of the light below the surface's horizon does not count.
fn diffuse_irradiance(light: Light, position_ws: vec3f, normal_ws: vec3f) -> f32 {
    return surface_irradiance(light, position_ws, transpose(basis_ws(normal_ws, light.right_ws)));
}

// The same, given the transform to a surface space.
fn surface_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    if !emits_toward(light, position_ws) {
        return 0.0;
    }
    if is_punctual(light) {
        let incoming = punctual_light(light, position_ws);
        return max((to_surface * incoming.xyz).z, 0.0) * incoming.w;
    }
    let center = to_surface * (light.center_ws - position_ws);
    let right = to_surface * light.right_ws * light.half_width;
    let up = to_surface * light.up_ws * light.half_height;
    switch light.kind {
        case RECT: { return rect_irradiance(center, right, up); }
        case DISK: { return disk_irradiance(center, right, up); }
        default: { return line_irradiance(center - right, center + right); }
    }
}

// Share of the light's area (or length) in front of the plane through the receiver: 1 for lights without size.
// Visibility counts the rest as hidden, irradiance leaves it out; dividing by this share counts it once.
fn fraction_above_horizon(light: Light, position_ws: vec3f, normal_ws: vec3f) -> f32 {
    if is_punctual(light) {
        return 1.0;
    }
    let height = dot(normal_ws, light.center_ws - position_ws);
    let drop_right = abs(light.half_width * dot(normal_ws, light.right_ws));
    let drop_up = abs(light.half_height * dot(normal_ws, light.up_ws));
    if light.kind == DISK {
        let t = clamp(height / max(length(vec2f(drop_right, drop_up)), TINY), -1.0, 1.0);
        return (acos(-t) + t * sqrt(1.0 - t * t)) / PI;
    }
    let more = max(drop_right, drop_up);
    let less = min(drop_right, drop_up);
    if less < 1e-3 * more || more == 0.0 {
        return saturate(0.5 + 0.5 * height / max(more, TINY));
    }
    // The rectangle's share of a half plane: second differences of a truncated square.
    let corners = max(vec4f(height) + vec4f(more + less, more - less, less - more, -more - less), vec4f(0.0));
    return saturate(dot(corners * corners, vec4f(1.0, -1.0, -1.0, 1.0)) / (8.0 * more * less));
}

// -- Reflection -------------------------------------------------------------------------------------------------------

fn load_bilinear(table: texture_2d<f32>, texel: vec2f) -> vec4f {
    let last = vec2f(textureDimensions(table) - 1u);
    let position = clamp(texel, vec2f(0.0), last);
    let low = vec2u(min(floor(position), last - 1.0));
    let weight = position - vec2f(low);
    let near = mix(textureLoad(table, low, 0), textureLoad(table, low + vec2u(1u, 0u), 0), weight.x);
    let far = mix(textureLoad(table, low + vec2u(0u, 1u), 0), textureLoad(table, low + vec2u(1u, 1u), 0), weight.x);
    return mix(near, far, weight.y);
}

// The two textures hold the table of benchmarks/fit_ltc.py, x = roughness, y = view: its matrix, its albedos.
// Diffuse is scaled by what the specular layer does not reflect of the view direction, where glTF 2.0 appendix B scales
// by 1 - F of the half vector: so an area light and the point light it shrinks to agree, and no energy is gained.
fn shading_lobes(surface: Surface, ltc_matrix: texture_2d<f32>, ltc_albedo: texture_2d<f32>) -> Lobes {
    let cosine = clamp(dot(surface.normal_ws, surface.view_ws), MIN_VIEW_COSINE, 1.0);
    let roughness = max(surface.roughness, MIN_ROUGHNESS);
    let last = vec2f(textureDimensions(ltc_matrix) - 1u);
    let texel = vec2f((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS), sqrt(1.0 - cosine)) * last;
    let m = load_bilinear(ltc_matrix, texel);
    let albedo = load_bilinear(ltc_albedo, texel).xy;

    let reflectance = mix(vec3f(DIELECTRIC_REFLECTANCE), surface.base_color, surface.metallic);
    let dielectric_albedo = mix(albedo.y, albedo.x, DIELECTRIC_REFLECTANCE);
    return Lobes(
        transpose(basis_ws(surface.normal_ws, surface.view_ws)),
        mat3x3f(m.x, 0.0, m.z, 0.0, 1.0, 0.0, m.y, 0.0, m.w),
        0.5 + 0.5 * m.x * inverseSqrt(m.x * m.x + m.z * m.z),
        reflectance * albedo.x + (1.0 - reflectance) * albedo.y,
        surface.base_color * (1.0 - surface.metallic) * (1.0 - dielectric_albedo),
        reflectance,
    );
}

// Specular radiance per unit emission from a light with size: the lobe's share of light times its albedo.
fn area_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    let center = lobes.to_surface * (light.center_ws - surface.position_ws);
    let right = lobes.to_surface * light.right_ws * light.half_width;
    let up = lobes.to_surface * light.up_ws * light.half_height;
    var irradiance = 0.0;
    if light.kind == LINE {
        irradiance = line_lobe_irradiance(lobes.to_lobe, center - right, center + right);
    } else {
        var outline = LobeOutline();
        let corners = select(4u, DISK_CORNERS, light.kind == DISK);
        var corner = center;
        for (var i = 0u; i <= corners; i++) {
            let next = outline_corner(light.kind, center, right, up, i);
            if i > 0u {
                add_lobe_edge(&outline, lobes.to_lobe, corner, next);
            }
            corner = next;
        }
        irradiance = abs(close_lobe_outline(outline, lobes.to_lobe));
    }
    return lobes.specular_albedo * (irradiance / (PI * lobes.above_horizon));
}

// GGX times cos θ_l in one direction: Walter et al. 2007; Heitz, JCGT 3(2), 2014; Schlick 1994. 1/sr.
fn punctual_specular(direction_ws: vec3f, surface: Surface, lobes: Lobes) -> vec3f {
    let light_cosine = dot(surface.normal_ws, direction_ws);
    if light_cosine <= 0.0 {
        return vec3f(0.0);
    }
    let view_cosine = max(dot(surface.normal_ws, surface.view_ws), MIN_VIEW_COSINE);
    let half_ws = normalize(direction_ws + surface.view_ws);
    let roughness = max(surface.roughness, MIN_ROUGHNESS);
    let alpha_squared = roughness * roughness * roughness * roughness;
    let off_normal = cross(surface.normal_ws, half_ws);  // sin² keeps its digits where cos² is nearly 1
    let half_cosine = dot(surface.normal_ws, half_ws);
    let spread = alpha_squared * half_cosine * half_cosine + dot(off_normal, off_normal);
    let distribution = alpha_squared / (PI * spread * spread);
    let view_masking = light_cosine * sqrt(alpha_squared + (1.0 - alpha_squared) * view_cosine * view_cosine);
    let light_masking = view_cosine * sqrt(alpha_squared + (1.0 - alpha_squared) * light_cosine * light_cosine);
    let grazing = pow(1.0 - saturate(dot(surface.view_ws, half_ws)), 5.0);
    let fresnel = lobes.reflectance + (1.0 - lobes.reflectance) * grazing;
    return fresnel * (distribution * 0.5 * light_cosine / (view_masking + light_masking));
}

// Radiance reflected to the viewer if nothing stood between the light and the surface, W/(m² sr).
fn unshadowed_radiance(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    if !emits_toward(light, surface.position_ws) {
        return vec3f(0.0);
    }
    let irradiance = surface_irradiance(light, surface.position_ws, lobes.to_surface);
    var specular = vec3f(0.0);
    if is_punctual(light) {
        let incoming = punctual_light(light, surface.position_ws);
        specular = incoming.w * punctual_specular(incoming.xyz, surface, lobes);
    } else {
        specular = area_specular(light, surface, lobes);
    }
    return light.emission * (lobes.diffuse_albedo * (irradiance / PI) + specular);
}
