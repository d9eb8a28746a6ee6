// Light without size: it arrives from one direction.

//#include "light.wgsl"
//#include "surface.wgsl"

struct Arrival {
    direction_ws: vec3f,  // unit, to the light
    irradiance: f32,      // of a surface that faces it, per unit emission
};

fn arrival_irradiance(arrival: Arrival, to_surface: mat3x3f) -> f32 {
    return max((to_surface * arrival.direction_ws).z, 0.0) * arrival.irradiance;
}

fn arrival_specular(arrival: Arrival, surface: Surface, lobes: Lobes) -> vec3f {
    return arrival.irradiance * ggx(arrival.direction_ws, surface, lobes);
}

// GGX times cos θ_l in one direction: Walter et al. 2007; Heitz, JCGT 3(2), 2014; Schlick 1994. 1/sr.
fn ggx(direction_ws: vec3f, surface: Surface, lobes: Lobes) -> vec3f {
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
