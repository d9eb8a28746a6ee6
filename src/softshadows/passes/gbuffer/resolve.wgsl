// What the camera sees, second step: the camera ray through each pixel's centre meets the pixel's triangle, which gives a
// position that lies in the triangle's plane to float precision, whatever the rasteriser interpolates.

//#include "frame.wgsl"
//#include "gpu/texture.wgsl"
//#include "gpu/packing.wgsl"

@group(0) @binding(1) var triangle_numbers: texture_2d<u32>;
@group(0) @binding(2) var g_position: texture_storage_2d<rgba32float, write>;  // xyz world, w = linear view depth, 0 = no surface
@group(0) @binding(3) var g_normal: texture_storage_2d<rgba32float, write>;    // geometric normal facing the viewer, triangle
@group(0) @binding(4) var g_material: texture_storage_2d<rgba32uint, write>;   // see packing.wgsl and lighting.wgsl

const NO_NORMAL = 0xffffffffu;

// Barycentric coordinates of vertices 1 and 2 where the ray from the eye meets the triangle's plane (Möller and Trumbore 1997).
fn ray_barycentrics(direction_ws: vec3f, corner_ws: vec3f, edge_1_ws: vec3f, edge_2_ws: vec3f) -> vec2f {
    let p = cross(direction_ws, edge_2_ws);
    let determinant = dot(edge_1_ws, p);
    if determinant == 0.0 {
        return vec2f(1.0 / 3.0);
    }
    let to_eye_ws = frame.camera_position_ws - corner_ws;
    let u = dot(to_eye_ws, p) / determinant;
    let v = dot(direction_ws, cross(to_eye_ws, edge_1_ws)) / determinant;
    return vec2f(u, v);
}

// Rasterisers snap vertices to a fraction of a pixel, so a pixel's centre can lie just outside its triangle.
fn clamp_barycentrics(uv: vec2f) -> vec3f {
    let weights = max(vec3f(1.0 - uv.x - uv.y, uv.x, uv.y), vec3f(0.0));
    return weights / (weights.x + weights.y + weights.z);
}

fn blend_texcoords(vertices: vec3u, weights: vec3f) -> vec4f {
    return vertex_attributes[vertices.x].texcoords * weights.x + vertex_attributes[vertices.y].texcoords * weights.y
        + vertex_attributes[vertices.z].texcoords * weights.z;
}

fn blend_normal_ws(vertices: vec3u, weights: vec3f, geometric_normal_ws: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < 3u; i++) {
        let bits = vertex_attributes[vertices[i]].normal;
        if bits == NO_NORMAL {
            return geometric_normal_ws;
        }
        sum += weights[i] * unpack_normal(bits);
    }
    return select(geometric_normal_ws, normalize(sum), dot(sum, sum) > 1e-12);
}

@compute @workgroup_size(8, 8)
fn cs_resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let number = textureLoad(triangle_numbers, id.xy, 0).r;
    if number == 0u {
        textureStore(g_position, id.xy, vec4f(0.0));
        textureStore(g_normal, id.xy, vec4f(0.0));
        textureStore(g_material, id.xy, vec4u(0u));
        return;
    }

    // Meet the triangle.
    let triangle = number - 1u;
    let vertices = triangle_vertices(triangle);
    let corner_ws = vertex_position_ws(vertices.x);
    let edge_1_ws = vertex_position_ws(vertices.y) - corner_ws;
    let edge_2_ws = vertex_position_ws(vertices.z) - corner_ws;
    let pixel = vec2f(id.xy) + 0.5;
    let weights = clamp_barycentrics(ray_barycentrics(camera_ray_ws(pixel), corner_ws, edge_1_ws, edge_2_ws));
    let position_ws = corner_ws + weights.y * edge_1_ws + weights.z * edge_2_ws;
    let to_surface_ws = position_ws - frame.camera_position_ws;
    let depth = max(-dot(to_surface_ws, frame.camera_back_ws), frame.near);

    // Turn the normals to the viewer.
    let front = dot(face_normal_ws(triangle), to_surface_ws) <= 0.0;
    let geometric_normal_ws = select(-1.0, 1.0, front) * face_normal_ws(triangle);
    var normal_ws = blend_normal_ws(vertices, weights, face_normal_ws(triangle));
    normal_ws *= select(-1.0, 1.0, front);

    // Read the material.
    let material = materials[triangle_material(triangle)];
    let texcoords = blend_texcoords(vertices, weights);
    let bary_dx = ray_barycentrics(camera_ray_ws(pixel + vec2f(1.0, 0.0)), corner_ws, edge_1_ws, edge_2_ws);
    let bary_dy = ray_barycentrics(camera_ray_ws(pixel + vec2f(0.0, 1.0)), corner_ws, edge_1_ws, edge_2_ws);
    let texcoords_dx = blend_texcoords(vertices, vec3f(1.0 - bary_dx.x - bary_dx.y, bary_dx)) - texcoords;
    let texcoords_dy = blend_texcoords(vertices, vec3f(1.0 - bary_dy.x - bary_dy.y, bary_dy)) - texcoords;
    var color = material.base_color.rgb * (weights.x * vertex_color(vertices.x).rgb + weights.y * vertex_color(vertices.y).rgb
        + weights.z * vertex_color(vertices.z).rgb);
    for (var is_textured = material.base_color_texture >= 0; is_textured; is_textured = false) {
        color *= sample_texture(material.base_color_texture, texcoords, texcoords_dx, texcoords_dy, true).rgb;
    }
    var roughness_metallic = vec2f(material.roughness, material.metallic);
    for (var is_textured = material.metallic_roughness_texture >= 0; is_textured; is_textured = false) {
        roughness_metallic *=
            sample_texture(material.metallic_roughness_texture, texcoords, texcoords_dx, texcoords_dy, false).gb;
    }
    var emission = material.emission;
    for (var is_textured = material.emission_texture >= 0; is_textured; is_textured = false) {
        emission *= sample_texture(material.emission_texture, texcoords, texcoords_dx, texcoords_dy, true).rgb;
    }

    textureStore(g_position, id.xy, vec4f(position_ws, depth));
    textureStore(g_normal, id.xy, vec4f(geometric_normal_ws, f32(triangle)));
    textureStore(g_material, id.xy, vec4u(
        pack_normal(normal_ws),
        pack4x8unorm(vec4f(linear_to_srgb(color), 1.0)),
        pack2x16unorm(roughness_metallic),
        pack_rgb9e5(emission),
    ));
}
