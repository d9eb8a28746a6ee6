// The scene's geometry, materials and textures: bind group 1 of every pass that needs them (gpu/upload.py).

//#struct VertexAttributes
//#struct MaterialRecord
//#struct TextureRecord

@group(1) @binding(0) var<storage, read> vertex_positions_ws: array<f32>;
@group(1) @binding(1) var<storage, read> triangle_indices: array<u32>;
@group(1) @binding(2) var<storage, read> vertex_attributes: array<VertexAttributes>;
@group(1) @binding(3) var<storage, read> faces: array<vec4f>;
@group(1) @binding(4) var<storage, read> materials: array<MaterialRecord>;
@group(1) @binding(5) var<storage, read> texture_records: array<TextureRecord>;
@group(1) @binding(6) var texture_pages: texture_2d_array<f32>;

fn triangle_vertices(triangle: u32) -> vec3u {
    return vec3u(triangle_indices[3u * triangle], triangle_indices[3u * triangle + 1u], triangle_indices[3u * triangle + 2u]);
}

fn vertex_position_ws(vertex: u32) -> vec3f {
    return vec3f(vertex_positions_ws[3u * vertex], vertex_positions_ws[3u * vertex + 1u], vertex_positions_ws[3u * vertex + 2u]);
}

fn vertex_color(vertex: u32) -> vec4f {
    let attributes = vertex_attributes[vertex];
    return vec4f(unpack2x16unorm(attributes.color_rg), unpack2x16unorm(attributes.color_ba));
}

// Unit normal by winding; zero for a degenerate triangle.
fn face_normal_ws(triangle: u32) -> vec3f {
    return faces[triangle].xyz;
}

fn triangle_material(triangle: u32) -> u32 {
    return u32(faces[triangle].w);
}
