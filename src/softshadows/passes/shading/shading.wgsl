// Linear radiance of every pixel: the surface's emission, and each light's unshadowed radiance times its visibility.

//#include "passes/gbuffer/receiver.wgsl"
//#include "gpu/packing.wgsl"
//#include "lights/radiance.wgsl"

struct Lights {
    count: u32,
    list: array<Light>,
};

// x = shading normal (octahedral, 2 snorm16), y = base colour (sRGB, 4 unorm8), z = roughness and metallic (2 unorm16),
// w = emission (RGB9E5)
@group(0) @binding(3) var g_material: texture_2d<u32>;
@group(0) @binding(4) var<storage, read> lights: Lights;
@group(0) @binding(5) var<storage, read> visibility: array<f32>;  // [light][y][x]
@group(0) @binding(6) var ltc_matrix: texture_2d<f32>;
@group(0) @binding(7) var ltc_albedo: texture_2d<f32>;
@group(0) @binding(8) var color: texture_storage_2d<rgba32float, write>;  // linear radiance; alpha 1 on surfaces

const MIN_FRACTION = 1e-4;  // of a light above the horizon: less lights nothing

fn load_surface(receiver: Receiver, material: vec4u) -> Surface {
    let roughness_metallic = unpack2x16unorm(material.z);
    return Surface(
        receiver.position_ws,
        unpack_normal(material.x),
        normalize(frame.camera_position_ws - receiver.position_ws),
        srgb_to_linear(unpack4x8unorm(material.y).rgb),
        roughness_metallic.y,
        roughness_metallic.x,
    );
}

@compute @workgroup_size(8, 8)
fn cs_shade(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let receiver = load_receiver(id.xy);
    if !receiver.is_surface {
        textureStore(color, id.xy, vec4f(0.0));
        return;
    }
    let material = textureLoad(g_material, id.xy, 0);
    let surface = load_surface(receiver, material);
    let lobes = shading_lobes(surface, ltc_matrix, ltc_albedo);
    var radiance = unpack_rgb9e5(material.w);
    for (var i = 0u; i < lights.count; i++) {
        let light = lights.list[i];
        let visible = visibility[(i * frame.size.y + id.y) * frame.size.x + id.x];
        // Irradiance is of the part of the light above the horizon, so visibility has to be of that part too.
        let above = fraction_above_horizon(light, receiver.position_ws, receiver.normal_ws);
        radiance += min(visible / max(above, MIN_FRACTION), 1.0) * unshadowed_radiance(light, surface, lobes);
    }
    textureStore(color, id.xy, vec4f(radiance, 1.0));
}
