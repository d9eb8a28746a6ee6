// Draw the occluders into the views of one chunk of light samples: one instance per view, kept in its place by clip distances.

enable clip_distances;

//#include "occluder.wgsl"

struct Occluder {
    @builtin(position) position_cs: vec4f,
    @builtin(clip_distances) inside: array<f32, 4>,
};

struct MaskedOccluder {
    @builtin(position) position_cs: vec4f,
    @builtin(clip_distances) inside: array<f32, 4>,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
};

// Nothing is in a view before its triangles: two triangles over it, whose depth always passes.
@vertex
fn vs_clear(@builtin(vertex_index) index: u32, view: View) -> @builtin(position) vec4f {
    return vec4f(view_corner(index, view) - 1.0, 0.0, 1.0) * vec4f(1.0, -1.0, 1.0, 1.0);
}

@vertex
fn vs_opaque(@location(0) position_ws: vec3f, view: View) -> Occluder {
    let projection = project(position_ws, view);
    return Occluder(projection.position_cs, projection.inside);
}

@vertex
fn vs_masked(@builtin(vertex_index) index: u32, view: View) -> MaskedOccluder {
    let vertex = triangle_indices[index];
    let projection = project(vertex_position_ws(vertex), view);
    return MaskedOccluder(
        projection.position_cs,
        projection.inside,
        index / 3u,
        vertex_attributes[vertex].texcoords,
        vertex_color(vertex).a,
    );
}

struct MaskedFragment {
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
};

@fragment
fn fs_masked(fragment: MaskedFragment) {
    if is_cut_out(fragment.triangle, fragment.texcoords, fragment.alpha) {
        discard;
    }
}
