// What the camera sees, first step: the number of the nearest triangle at every pixel (a visibility buffer, Burns and Hunt 2013).
// Reversed z with an infinite far plane: depth = near / distance.

//#include "frame.wgsl"
//#include "gpu/texture.wgsl"

struct Fragment {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
};

@vertex
fn vs_triangle(@builtin(vertex_index) index: u32) -> Fragment {
    let triangle = index / 3u;
    let vertex = triangle_indices[index];
    let to_vertex_ws = vertex_position_ws(vertex) - frame.camera_position_ws;
    let distance = -dot(to_vertex_ws, frame.camera_back_ws);
    var out: Fragment;
    out.triangle = triangle;
    out.position_cs = vec4f(
        dot(to_vertex_ws, frame.camera_right_ws) / frame.tan_half_width,
        dot(to_vertex_ws, frame.camera_up_ws) / frame.tan_half_height,
        frame.near,
        distance,
    );
    // A single-sided triangle seen from behind is not there, nor is one without a plane. Decided by the plane, so that all
    // three vertices agree.
    let seen_from_behind = dot(face_normal_ws(triangle), to_vertex_ws) > 0.0;
    let is_degenerate = all(face_normal_ws(triangle) == vec3f(0.0));
    if is_degenerate || (seen_from_behind && materials[triangle_material(triangle)].double_sided == 0u) {
        out.position_cs = vec4f(0.0, 0.0, -1.0, 1.0);
    }
    out.texcoords = vertex_attributes[vertex].texcoords;
    out.alpha = vertex_color(vertex).a;
    return out;
}

@fragment
fn fs_opaque(fragment: Fragment) -> @location(0) u32 {
    return fragment.triangle + 1u;
}

@fragment
fn fs_masked(fragment: Fragment) -> @location(0) u32 {
    let material = materials[triangle_material(fragment.triangle)];
    if surface_alpha(material, fragment.texcoords, fragment.alpha) < material.alpha_cutoff {
        discard;
    }
    return fragment.triangle + 1u;
}
