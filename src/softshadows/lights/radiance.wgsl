// Light that reaches a point from a whole light, unshadowed, and what the surface there reflects of it.
//
// Every kind of light has a file of its own, which says for emission 1
//     <kind>_irradiance(light, position_ws, to_surface)   W/m² on the plane z = 0 of surface space, less what is below it
//     <kind>_specular(light, surface, lobes)              W/(m² sr) that the specular lobe reflects
// Lengths in metres, emission in the units of scene/lights.py.

//#include "rect.wgsl"
//#include "disk.wgsl"
//#include "line.wgsl"
//#include "point.wgsl"
//#include "spot.wgsl"
//#include "directional.wgsl"

const RECT = 0u;
const DISK = 1u;
const LINE = 2u;
const POINT = 3u;
const SPOT = 4u;
const DIRECTIONAL = 5u;

// One loop for each kind, of at most one round: drivers would run all branches of a switch (gpu/driver.wgsl).
fn irradiance_of(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    var irradiance = 0.0;
    for (var is_kind = light.kind == RECT; is_kind; is_kind = false) {
        irradiance = rect_irradiance(light, position_ws, to_surface);
    }
    for (var is_kind = light.kind == DISK; is_kind; is_kind = false) {
        irradiance = disk_irradiance(light, position_ws, to_surface);
    }
    for (var is_kind = light.kind == LINE; is_kind; is_kind = false) {
        irradiance = line_irradiance(light, position_ws, to_surface);
    }
    for (var is_kind = light.kind == POINT; is_kind; is_kind = false) {
        irradiance = point_irradiance(light, position_ws, to_surface);
    }
    for (var is_kind = light.kind == SPOT; is_kind; is_kind = false) {
        irradiance = spot_irradiance(light, position_ws, to_surface);
    }
    for (var is_kind = light.kind == DIRECTIONAL; is_kind; is_kind = false) {
        irradiance = directional_irradiance(light, position_ws, to_surface);
    }
    return irradiance;
}

fn specular_of(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    var specular = vec3f(0.0);
    for (var is_kind = light.kind == RECT; is_kind; is_kind = false) {
        specular = rect_specular(light, surface, lobes);
    }
    for (var is_kind = light.kind == DISK; is_kind; is_kind = false) {
        specular = disk_specular(light, surface, lobes);
    }
    for (var is_kind = light.kind == LINE; is_kind; is_kind = false) {
        specular = line_specular(light, surface, lobes);
    }
    for (var is_kind = light.kind == POINT; is_kind; is_kind = false) {
        specular = point_specular(light, surface, lobes);
    }
    for (var is_kind = light.kind == SPOT; is_kind; is_kind = false) {
        specular = spot_specular(light, surface, lobes);
    }
    for (var is_kind = light.kind == DIRECTIONAL; is_kind; is_kind = false) {
        specular = directional_specular(light, surface, lobes);
    }
    return specular;
}

// False behind a one-sided light.
fn emits_toward(light: Light, position_ws: vec3f) -> bool {
    return light.is_one_sided == 0u || dot(light.back_ws, position_ws - light.center_ws) < 0.0;
}

// Irradiance (W/m²) of a surface for emission 1; the part of the light below the surface's horizon does not count.
fn diffuse_irradiance(light: Light, position_ws: vec3f, normal_ws: vec3f) -> f32 {
    if !emits_toward(light, position_ws) {
        return 0.0;
    }
    return irradiance_of(light, position_ws, transpose(basis_ws(normal_ws, light.right_ws)));
}

// Share of the light's area (or length) in front of the plane through the receiver: 1 for lights without size.
// Visibility counts the rest as hidden, irradiance leaves it out; dividing by this share counts it once.
fn fraction_above_horizon(light: Light, position_ws: vec3f, normal_ws: vec3f) -> f32 {
    if is_point(light) {
        return 1.0;
    }
    let height = dot(normal_ws, light.center_ws - position_ws);
    let drop_right = abs(light.half_width * dot(normal_ws, light.right_ws));
    let drop_up = abs(light.half_height * dot(normal_ws, light.up_ws));
    if light.is_round == 1u {
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

// Radiance reflected to the viewer if nothing stood between the light and the surface, W/(m² sr).
fn unshadowed_radiance(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    if !emits_toward(light, surface.position_ws) {
        return vec3f(0.0);
    }
    let irradiance = irradiance_of(light, surface.position_ws, lobes.to_surface);
    let specular = specular_of(light, surface, lobes);
    return light.emission * (lobes.diffuse_albedo * (irradiance / PI) + specular);
}
