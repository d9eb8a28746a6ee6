// What the camera sees, first step: the number of the nearest triangle at every pixel (a visibility buffer, Burns and Hunt 2013).
// Reversed z with an infinite far plane: depth = near / distance.

//#include "frame.wgsl"
//#include "gpu/texture.wgsl"

struct Opaque {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
};

struct Masked {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
};

// A single-sided triangle seen from behind is not there, nor is one without a plane: outside of clip space. Decided by the plane,
// so that all three vertices agree.
fn position_cs(triangle: u32, vertex: u32) -> vec4f {
    let face = faces[triangle];
    let to_vertex_ws = vertex_position_ws(vertex) - frame.camera_position_ws;
    let seen_from_behind = dot(face.xyz, to_vertex_ws) > 0.0;
    let is_degenerate = all(face.xyz == vec3f(0.0));
    if is_degenerate || (seen_from_behind && materials[u32(face.w)].double_sided == 0u) {
        return vec4f(0.0, 0.0, -1.0, 1.0);
    }
    return vec4f(
        dot(to_vertex_ws, frame.camera_right_ws) / frame.tan_half_width,
        dot(to_vertex_ws, frame.camera_up_ws) / frame.tan_half_height,
        frame.near,
        -dot(to_vertex_ws, frame.camera_back_ws),
    );
}

@vertex
fn vs_opaque(@builtin(vertex_index) index: u32) -> Opaque {
    let triangle = index / 3u;
    return Opaque(position_cs(triangle, triangle_indices[index]), triangle);
}

@vertex
fn vs_masked(@builtin(vertex_index) index: u32) -> Masked {
    let triangle = index / 3u;
    let vertex = triangle_indices[index];
    return Masked(position_cs(triangle, vertex), triangle, vertex_attributes[vertex].texcoords, vertex_color(vertex).a);
}

@fragment
fn fs_opaque(fragment: Opaque) -> @location(0) u32 {
    return fragment.triangle + 1u;
}

@fragment
fn fs_masked(fragment: Masked) -> @location(0) u32 {
    let material = materials[triangle_material(fragment.triangle)];
    if surface_alpha(material, fragment.texcoords, fragment.alpha) < material.alpha_cutoff {
        discard;
    }
    return fragment.triangle + 1u;
}
