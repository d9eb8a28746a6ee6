// Points without size that emit into a cone.

//#include "point.wgsl"

const MIN_SPOT_FALLOFF = 0.001;  // KHR_lights_punctual: least difference of the two cosines

// KHR_lights_punctual, "inner and outer cone angles"
fn spot_arrival(light: Light, position_ws: vec3f) -> Arrival {
    var arrival = point_arrival(light, position_ws);
    let falloff = max(light.cos_inner - light.cos_outer, MIN_SPOT_FALLOFF);
    let inside = saturate((dot(light.back_ws, arrival.direction_ws) - light.cos_outer) / falloff);
    arrival.irradiance *= inside * inside;
    return arrival;
}

fn spot_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    return arrival_irradiance(spot_arrival(light, position_ws), to_surface);
}

fn spot_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    return arrival_specular(spot_arrival(light, surface.position_ws), surface, lobes);
}
