// Parallel light.

//#include "arrival.wgsl"

fn directional_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    return arrival_irradiance(Arrival(light.back_ws, 1.0), to_surface);
}

fn directional_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    return arrival_specular(Arrival(light.back_ws, 1.0), surface, lobes);
}
