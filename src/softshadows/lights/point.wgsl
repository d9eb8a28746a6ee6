// Points without size that emit all around.

//#include "arrival.wgsl"

fn point_arrival(light: Light, position_ws: vec3f) -> Arrival {
    let to_light_ws = light.center_ws - position_ws;
    let squared = max(dot(to_light_ws, to_light_ws), TINY);
    return Arrival(to_light_ws * inverseSqrt(squared), 1.0 / squared);
}

fn point_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    return arrival_irradiance(point_arrival(light, position_ws), to_surface);
}

fn point_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    return arrival_specular(point_arrival(light, surface.position_ws), surface, lobes);
}
