// Where a vertex falls in a view of the shadow atlas: what both ways of drawing the occluders share.

//#include "texture.wgsl"
//#include "light_space.wgsl"
//#struct Chunk

@group(0) @binding(0) var<uniform> light: ShadowLight;
@group(0) @binding(1) var<storage, read> light_samples: array<vec4f>;
@group(0) @binding(2) var<storage, read> shadow_views: array<ShadowView>;
@group(0) @binding(3) var<storage, read> draw_list: array<u32>;
@group(0) @binding(4) var<uniform> chunk: Chunk;

struct Projection {
    position_cs: vec4f,
    inside: array<f32, 4>,  // distances from the view's edges in texels, times w; negative outside
};

fn project(position_ws: vec3f, view_index: u32) -> Projection {
    let view = shadow_views[view_index];
    let sample_ls = vec3f(light_samples[view_index / FACES].xy, 0.0);
    let point = face_coordinates(view_index % FACES, to_light_space(light, position_ws - light.center_ws) - sample_ls);
    let is_directional = light.is_directional == 1u;
    let w = select(point.z, 1.0, is_directional);
    let texel = (point.xy - view.window_low * w) * view.texels_per_unit;  // from the view's low corner, times w
    let room = vec2f(view.size) * w - texel;
    let ndc = (texel + vec2f(view.origin) * w) * (2.0 / f32(light.atlas_size));  // from the atlas's low corner, times w
    let closeness_w = select(1.0, closeness_of(light, point.z), is_directional);
    let clip = vec4f(ndc.x - w, w - ndc.y, closeness_w * light.depth_scale, w);
    return Projection(clip, array<f32, 4>(texel.x, texel.y, room.x, room.y));
}

// The view that an instance of the chunk's draw stands for.
fn view_of_instance(instance: u32) -> u32 {
    return draw_list[chunk.first_view + instance];
}

fn is_cut_out(triangle: u32, texcoords: vec4f, vertex_alpha: f32) -> bool {
    let material = materials[triangle_material(triangle)];
    return surface_alpha(material, texcoords, vertex_alpha) < material.alpha_cutoff;
}
