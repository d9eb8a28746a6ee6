// Edges of the shadow map: what the mask is made from, and what both kinds of it share.

//#include "passes/gbuffer/pixel.wgsl"
//#include "visibility/maps/shadow_map.wgsl"

@group(1) @binding(0) var last_layer: texture_depth_2d;  // inverse depth of the farthest surface, 1 = nothing; if there are two layers
@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(3) @binding(1) var<storage, read_write> taps: array<vec2f>;
@group(3) @binding(2) var<storage, read_write> mask: array<atomic<u32>>;
@group(3) @binding(3) var<storage, read_write> span: Span;
@group(3) @binding(4) var<storage, read_write> counters: array<Reads, COUNTERS>;

// What the map holds, as bits of its floats, which sort like the floats when those are positive.
struct Span {
    nearest: atomic<u32>,
    inverted_farthest: atomic<u32>,  // so that 0 stands for nothing yet
    solid_triangles: u32,            // in front of all others: the occluders of a scene without self-shadowing
};

// What sets pixels apart from most, which read the mask and one texel of the map, so that those need no atomics.
struct Reads {
    further_reads: atomic<u32>,
    absent_pixels: atomic<u32>,  // that did not look into the map
};

override neighbours: u32;       // of the edge filter, 4 or 8
override self_shadowing: bool;
override layers: u32;           // of the map that are known: the nearest surface, and perhaps the last one

const THIN_TEXELS = 8.0;        // nearer than that to the last surface, a surface counts as the last one
const SPAN_ROWS = 8u;
const COUNTERS = 128u;          // so that pixels rarely wait for each other

// The nearest and the farthest surface in the map. An invocation looks at SPAN_ROWS texels of a column: most of its time goes
// into its beginning and its end.
@compute @workgroup_size(8, 8)
fn cs_span(@builtin(global_invocation_id) id: vec3u) {
    let last_texel = textureDimensions(shadow_atlas) - 1u;
    var nearest = 0u;
    var inverted_farthest = 0u;
    for (var row = 0u; row < SPAN_ROWS; row++) {
        let texel = min(vec2u(id.x, SPAN_ROWS * id.y + row), last_texel);
        let bits = bitcast<u32>(textureLoad(shadow_atlas, texel, 0));
        nearest = max(nearest, bits);
        inverted_farthest = max(inverted_farthest, select(0u, ~bits, bits != 0u));
    }
    if nearest > atomicLoad(&span.nearest) {
        atomicMax(&span.nearest, nearest);
    }
    if inverted_farthest > atomicLoad(&span.inverted_farthest) {
        atomicMax(&span.inverted_farthest, inverted_farthest);
    }
}

fn nearest_inverse_depth() -> f32 {
    return bitcast<f32>(atomicLoad(&span.nearest)) / maps.depth_scale;
}

fn farthest_inverse_depth() -> f32 {
    return bitcast<f32>(~atomicLoad(&span.inverted_farthest)) / maps.depth_scale;
}

fn texel_inverse_depth(texel: vec2u) -> f32 {
    return textureLoad(shadow_atlas, texel, 0) / maps.depth_scale;
}

fn texels_per_unit(texel: vec2u) -> vec2f {
    for (var i = 0u; i < FACES; i++) {
        let view = shadow_views[i];
        if all(texel >= view.origin) && all(texel < view.origin + view.size) {
            return view.texels_per_unit;
        }
    }
    return vec2f(1.0);
}

// [Evans2014 §5] Which edges concern a surface: those that have it, or another like it, for their background. 0: it is the last
// one, 1: something lies behind it, as behind an arm's edge before the body, whose shadow on the floor that edge does not bound.
fn layer_of(inverse_depth: f32, texel: vec2u, texels_per_unit: vec2f) -> u32 {
    if layers == 1u {
        return 0u;
    }
    let last = textureLoad(last_layer, texel, 0) / maps.depth_scale;
    let texel_extent = 1.0 / min(texels_per_unit.x, texels_per_unit.y);
    let thickness = THIN_TEXELS * inverse_depth_of_extent(inverse_depth, texel_extent);
    return select(0u, 1u, inverse_depth - last > thickness);
}

fn layer_of_background(texel: vec2u) -> u32 {
    return layer_of(texel_inverse_depth(texel), texel, texels_per_unit(texel));
}

fn layer_of_receiver(map_sample: MapSample) -> u32 {
    if layers == 1u {
        return 0u;
    }
    let view = shadow_views[map_sample.view];
    let texel = covering_texel(map_sample);
    let center = view.window_low + (vec2f(texel) + 0.5) / view.texels_per_unit;
    let on_plane = plane_inverse_depth(map_sample.plane_normal, map_sample.plane_offset, center);
    map_reads++;
    return layer_of(on_plane, view.origin + texel, view.texels_per_unit);
}

// Does a view hold the texel and all its neighbours? At a view's border a plane's slope would look like an edge.
fn has_neighbours(texel: vec2u) -> bool {
    let view = view_around(texel);
    return view.z != 0u && all(texel > view.xy) && all(texel + 1u < view.zw);
}

// Does the filter look at the texel `step` away?
fn is_neighbour(step: vec2i) -> bool {
    let distance = abs(step.x) + abs(step.y);
    return distance == 1 || (neighbours == 8u && distance == 2);
}

// A straight edge then answers alike to both filters, which see one and three of its texels.
fn straight_edge_neighbours() -> f32 {
    return select(1.0, 3.0, neighbours == 8u);
}

// Solid things that cast but do not receive.
fn is_only_occluder(surface: Receiver) -> bool {
    return !self_shadowing && surface.triangle < f32(span.solid_triangles);
}

fn counter_of(workgroup: vec3u) -> u32 {
    return (workgroup.x + 7u * workgroup.y) % COUNTERS;
}

// Remember how often a pixel that looked into the map read it beyond the first time.
fn count_further_reads(workgroup: vec3u) {
    if map_reads > 1u {
        atomicAdd(&counters[counter_of(workgroup)].further_reads, map_reads - 1u);
    }
}

// Remember a pixel that did not look into the map.
fn count_absent_pixel(workgroup: vec3u) {
    atomicAdd(&counters[counter_of(workgroup)].absent_pixels, 1u);
}

// A pixel whose visibility the map and its mask decide. Of any other it is written already.
struct MaskedPixel {
    is_masked: bool,
    receiver: Receiver,
    map_sample: MapSample,     // from the light's centre
};

fn begin_masked_pixel(id: vec2u, workgroup: vec3u) -> MaskedPixel {
    var pixel: MaskedPixel;
    if any(id >= frame.size) {
        return pixel;
    }
    pixel.receiver = begin_pixel(id);
    if pixel.receiver.is_surface {
        let is_receiver = !is_only_occluder(pixel.receiver);
        pixel.map_sample = project_into_map(0u, pixel.receiver, pixel.receiver.position_ls);
        pixel.is_masked = is_receiver && pixel.map_sample.possible && pixel.map_sample.covered;
        visibility[pixel.receiver.index] = select(0.0, 1.0, pixel.map_sample.possible || !is_receiver);
    }
    if !pixel.is_masked {
        count_absent_pixel(workgroup);
    }
    return pixel;
}
