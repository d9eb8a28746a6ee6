// What lights with size share: how a surface sees them, and what its specular lobe does with their light.

//#include "light.wgsl"
//#include "surface.wgsl"

// A light in surface space.
struct SeenLight {
    center: vec3f,
    right: vec3f,  // half its extent
    up: vec3f,
};

fn seen_light(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> SeenLight {
    return SeenLight(
        to_surface * (light.center_ws - position_ws),
        to_surface * light.right_ws * light.half_width,
        to_surface * light.up_ws * light.half_height,
    );
}

// Specular radiance per unit emission: the lobe's share of light times its albedo. `irradiance` is that of the lobe's plane.
fn lobe_reflection(irradiance: f32, lobes: Lobes) -> vec3f {
    return lobes.specular_albedo * (irradiance / (PI * lobes.above_horizon));
}
