// Occluders are kept in their view by clip distances: no fragment lies outside.

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

struct MaskedFragment {
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) texcoords: vec4f,
    @location(2) alpha: f32,
};

fn occluder(projection: Projection, view: View) -> Occluder {
    return Occluder(projection.position_cs, projection.inside);
}

fn masked_occluder(projection: Projection, view: View, triangle: u32, texcoords: vec4f, alpha: f32) -> MaskedOccluder {
    return MaskedOccluder(projection.position_cs, projection.inside, triangle, texcoords, alpha);
}

fn is_outside(fragment: MaskedFragment) -> bool {
    return false;
}
