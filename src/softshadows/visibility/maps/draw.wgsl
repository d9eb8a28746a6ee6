// Draw the occluders into the views of one chunk of light samples: one instance per view, kept in its place by clip distances,
// or without them by fragments that are discarded (kept_by_discard.wgsl stands in).

//#include "kept_by_clipping.wgsl"

// Nothing is in a view before its triangles: two triangles over it, whose depth always passes.
@vertex
fn vs_clear(@builtin(vertex_index) index: u32, view: View) -> @builtin(position) vec4f {
    return vec4f(view_corner(index, view) - 1.0, 0.0, 1.0) * vec4f(1.0, -1.0, 1.0, 1.0);
}

@vertex
fn vs_opaque(@location(0) position_ws: vec3f, view: View) -> Occluder {
    return occluder(project(position_ws, view), view);
}

@vertex
fn vs_masked(@builtin(vertex_index) index: u32, view: View) -> MaskedOccluder {
    let vertex = triangle_indices[index];
    let projection = project(vertex_position_ws(vertex), view);
    return masked_occluder(projection, view, index / 3u, vertex_attributes[vertex].texcoords, vertex_color(vertex).a);
}

@fragment
fn fs_masked(fragment: MaskedFragment) {
    if is_outside(fragment) || is_cut_out(fragment.triangle, fragment.texcoords, fragment.alpha) {
        discard;
    }
}
