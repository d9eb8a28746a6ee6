// As draw.wgsl, for adapters without clip distances: fragments outside their view are discarded.

//#include "occluder.wgsl"

struct Occluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) view: u32,
};

struct MaskedOccluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) view: u32,
    @location(1) @interpolate(flat) triangle: u32,
    @location(2) texcoords: vec4f,
    @location(3) alpha: f32,
};

fn is_outside(view_index: u32, position: vec4f) -> bool {
    let view = shadow_views[view_index];
    let texel = vec2u(position.xy);
    return any(texel < view.origin) || any(texel >= view.origin + view.size);
}

@vertex
fn vs_opaque(@location(0) position_ws: vec3f, @builtin(instance_index) instance: u32) -> Occluder {
    let view = view_of_instance(instance);
    return Occluder(project(position_ws, view).position_cs, view);
}

@vertex
fn vs_masked(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> MaskedOccluder {
    let vertex = triangle_indices[index];
    let view = view_of_instance(instance);
    return MaskedOccluder(
        project(vertex_position_ws(vertex), view).position_cs,
        view,
        index / 3u,
        vertex_attributes[vertex].texcoords,
        vertex_color(vertex).a,
    );
}

@fragment
fn fs_opaque(fragment: Occluder) {
    if is_outside(fragment.view, fragment.position_cs) {
        discard;
    }
}

@fragment
fn fs_masked(fragment: MaskedOccluder) {
    if is_outside(fragment.view, fragment.position_cs) || is_cut_out(fragment.triangle, fragment.texcoords, fragment.alpha) {
        discard;
    }
}
