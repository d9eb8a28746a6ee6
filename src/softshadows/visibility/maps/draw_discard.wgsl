// As draw.wgsl, for adapters without clip distances: fragments outside their view are discarded.

//#include "occluder.wgsl"

struct Occluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) edges: vec4f,  // of the view, in texels
};

struct MaskedOccluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) edges: vec4f,  // of the view, in texels
    @location(1) @interpolate(flat) triangle: u32,
    @location(2) texcoords: vec4f,
    @location(3) alpha: f32,
};

fn is_outside(edges: vec4f, position: vec4f) -> bool {
    return any(position.xy < edges.xy) || any(position.xy > edges.zw);
}

fn atlas_edges(view: View) -> vec4f {
    return view.edges * (0.5 * f32(maps.atlas_size));
}

// Nothing is in a view before its triangles: two triangles over it, whose depth always passes.
@vertex
fn vs_clear(@builtin(vertex_index) index: u32, view: View) -> @builtin(position) vec4f {
    return vec4f(view_corner(index, view) - 1.0, 0.0, 1.0) * vec4f(1.0, -1.0, 1.0, 1.0);
}

@vertex
fn vs_opaque(@location(0) position_ws: vec3f, view: View) -> Occluder {
    return Occluder(project(position_ws, view).position_cs, atlas_edges(view));
}

@vertex
fn vs_masked(@builtin(vertex_index) index: u32, view: View) -> MaskedOccluder {
    let vertex = triangle_indices[index];
    return MaskedOccluder(
        project(vertex_position_ws(vertex), view).position_cs,
        atlas_edges(view),
        index / 3u,
        vertex_attributes[vertex].texcoords,
        vertex_color(vertex).a,
    );
}

@fragment
fn fs_opaque(fragment: Occluder) {
    if is_outside(fragment.edges, fragment.position_cs) {
        discard;
    }
}

@fragment
fn fs_masked(fragment: MaskedOccluder) {
    if is_outside(fragment.edges, fragment.position_cs) || is_cut_out(fragment.triangle, fragment.texcoords, fragment.alpha) {
        discard;
    }
}
