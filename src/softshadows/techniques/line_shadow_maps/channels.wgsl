// Visibility channels: skins drawn into the neighbouring map, as the share of the segment between both samples that is visible
// from there. [Heidrich2000 §3.2]
//
// A map has two channels, for the segments before (r) and after it (g). UNTOUCHED means no skin: 0.5 for a point that both
// samples see. Of overlapping skins the least value counts, by the blend.

//#include "visibility/line_maps/line_map.wgsl"
//#struct Skin

@group(1) @binding(0) var<storage, read> skins: array<Skin>;

override is_rational: bool = false;

const UNTOUCHED = 2.0;
const BEYOND_TEXELS = 1.0;   // by how much a skin reaches past its receiver, where hard tests and skins end a texel apart
const BIAS_TEXELS = 1.0;     // how far behind a surface a skin may lie: its ends touch surfaces, a texel off at most

struct SkinVertex {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(linear) share: f32,          // 0 at the occluder, 1 at the receiver
    @location(1) @interpolate(flat) is_after: u32,          // the segment after the map's sample, not before
    @location(2) @interpolate(flat) edge: vec2f,            // the occluder's u and inverse depth in this map
    @location(3) @interpolate(flat) segment: f32,           // from this sample to the skin's, metres along the light
    @location(4) @interpolate(flat) view: u32,
};

fn corner(index: u32) -> vec2f {
    return vec2f(
        select(0.0, 1.0, index == 1u || index == 2u || index == 4u),
        select(0.0, 1.0, index == 2u || index == 4u || index == 5u),
    );
}

// A place in the atlas, in texels, as clip coordinates.
fn clip_position(texel: vec2f, inverse_depth: f32) -> vec4f {
    let ndc = 2.0 * texel / f32(maps.atlas_size) - 1.0;
    return vec4f(ndc.x, -ndc.y, clamp(inverse_depth * maps.depth_scale, 0.0, 1.0), 1.0);
}

// The tile of every sample, to be emptied.
@vertex
fn vs_clear(@builtin(vertex_index) index: u32, @builtin(instance_index) sample: u32) -> @builtin(position) vec4f {
    let tile = vec2f(vec2u(sample % maps.tiles_per_row, sample / maps.tiles_per_row));
    return clip_position((tile + corner(index)) * f32(maps.tile_size), 1.0);
}

@fragment
fn fs_clear() -> @location(0) vec4f {
    return vec4f(UNTOUCHED);
}

// A skin is one row high in every map, for a row is a plane through the light, to within half a row.
@vertex
fn vs_skin(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> SkinVertex {
    let skin = skins[instance];
    let face = skin.ends & 0xffu;
    let source = (skin.ends >> 8u) & 0xffu;
    let own = skin.ends >> 16u;
    let column = f32(skin.texel & 0xffffu);
    let row = f32(skin.texel >> 16u);
    let view = shadow_views[own * FACES + face];

    // Between the texels of the jump, moved to this map.
    let u = column_position(source * FACES + face, column + 0.5);
    let segment = light_samples.points[source].x - light_samples.points[own].x;
    let edge = u + segment * skin.occluder_inverse_depth;
    let end = u + segment * skin.receiver_inverse_depth;
    let beyond = sign(end - edge) * BEYOND_TEXELS / view.texels_per_unit.x;

    // Its columns, as far as they lie in the view.
    let at = corner(index);
    let last = vec2f(0.0, f32(view.size.x));
    let wanted = (select(end + beyond, edge, at.x == 0.0) - view.window_low.x) * view.texels_per_unit.x;
    let x = clamp(wanted, last.x, last.y);
    let share = (view.window_low.x + x / view.texels_per_unit.x - edge) / (end - edge);
    let inverse_depth = mix(skin.occluder_inverse_depth, skin.receiver_inverse_depth, share);
    let bias = BIAS_TEXELS * inverse_depth_of_extent(skin.occluder_inverse_depth, 1.0 / view.texels_per_unit.x);

    var vertex: SkinVertex;
    vertex.position = clip_position(vec2f(view.origin) + vec2f(x, row + at.y), inverse_depth + bias);
    vertex.share = share;
    vertex.is_after = select(0u, 1u, source > own);
    vertex.edge = vec2f(edge, skin.occluder_inverse_depth);
    vertex.segment = segment;
    vertex.view = own * FACES + face;
    return vertex;
}

// [Heidrich2000 Eq. 1] The light is seen from this map's sample to where the line from the texel's own surface past the
// occluder's edge meets it. In tangents and inverse depthes that place is (edge - u) / (inverse depth of edge - of surface).
fn rational_share(vertex: SkinVertex) -> f32 {
    let view = shadow_views[vertex.view];
    let texel = vec2u(vertex.position.xy) - view.origin;
    let u = column_position(vertex.view, f32(texel.x));
    let apart = max(vertex.edge.y - map_inverse_depth(vertex.view, texel), 1e-6 * vertex.edge.y);
    return (vertex.edge.x - u) / (apart * vertex.segment);
}

@fragment
fn fs_skin(vertex: SkinVertex) -> @location(0) vec4f {
    var share = vertex.share;
    if is_rational {
        share = rational_share(vertex);
    }
    share = clamp(share, 0.0, 1.0);
    return select(vec4f(share, UNTOUCHED, 0.0, 0.0), vec4f(UNTOUCHED, share, 0.0, 0.0), vertex.is_after == 1u);
}
