// Stands in for kept_by_clipping.wgsl on adapters without clip distances: fragments outside their view are discarded.

//#include "occluder.wgsl"

struct Occluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) edges: vec4f,  // of the view, in texels
};

struct MaskedOccluder {
    @builtin(position) position_cs: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
    @location(3) @interpolate(flat) edges: vec4f,  // of the view, in texels
};

alias MaskedFragment = MaskedOccluder;

fn atlas_edges(view: View) -> vec4f {
    return view.edges * (0.5 * f32(maps.atlas_size));
}

fn occluder(projection: Projection, view: View) -> Occluder {
    return Occluder(projection.position_cs, atlas_edges(view));
}

fn masked_occluder(projection: Projection, view: View, triangle: u32, texcoords: vec4f, alpha: f32) -> MaskedOccluder {
    return MaskedOccluder(projection.position_cs, triangle, texcoords, alpha, atlas_edges(view));
}

fn is_beyond(edges: vec4f, position: vec4f) -> bool {
    return any(position.xy < edges.xy) || any(position.xy > edges.zw);
}

fn is_outside(fragment: MaskedFragment) -> bool {
    return is_beyond(fragment.edges, fragment.position_cs);
}

@fragment
fn fs_opaque(fragment: Occluder) {
    if is_beyond(fragment.edges, fragment.position_cs) {
        discard;
    }
}
