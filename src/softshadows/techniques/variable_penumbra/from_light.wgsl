// Variable penumbra from the light's size: edges of the shadow map tell the pixels that their penumbra reaches how near the
// occluder is, so that the width follows as in percentage-closer soft shadows, without a search for blockers.
//
// The mask has cells of 8×8 texels, each with the sum of the edges' inverse depth and their number, for each layer of the map.

//#include "edges.wgsl"
//#include "visibility/maps/light_filter.wgsl"

override tap_count: u32;

const CELL = 8u;                  // texels along a cell, and lanes along a workgroup
const LANES = 64u;
const LEVELS = 4095.0;            // of inverse depth, from 0 to the map's nearest; a million edges then fit a sum
const NARROWEST_TEXELS = 0.5;     // half a penumbra that is as good as none
const WIDEST_CELLS = 32;          // how far an edge reaches at most

// The edges of one cell.
struct CellEdges {
    inverse_depth: atomic<u32>,  // their sum
    count: atomic<u32>,
    reach_x: atomic<u32>,    // cells
    reach_y: atomic<u32>,
};

var<workgroup> cell_edges: array<CellEdges, 2>;  // by layer

struct Edge {
    inverse_depth: f32,      // of the occluder
    half_width: vec2f,   // of the penumbra behind it, in texels
};

// The Laplacian of the paper in inverse depth, which is linear on every plane, and the nearest of the
// neighbours. The half width is w (1/d_blocker - 1/d_receiver): in the map as wide as the light, seen through the edge.
fn edge_at(texel: vec2u) -> Edge {
    let here = texel_inverse_depth(texel);
    var sum = 0.0;
    var nearest = here;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            if is_neighbour(vec2i(x, y)) {
                let there = texel_inverse_depth(vec2u(vec2i(texel) + vec2i(x, y)));
                sum += there - here;
                nearest = max(nearest, there);
            }
        }
    }
    let light_texels = vec2f(light.half_width, light.half_height) * texels_per_unit(texel);
    let bend = max(light_texels.x, light_texels.y) * sum / straight_edge_neighbours();
    return Edge(nearest, select(vec2f(0.0), light_texels * (nearest - here), bend > NARROWEST_TEXELS));
}

fn cells_per_row() -> u32 {
    return (maps.atlas_size - 1u) / CELL + 1u;
}

// A cell's place in the mask.
fn mask_index(cell: vec2u, layer: u32) -> u32 {
    return 2u * (layers * (cell.y * cells_per_row() + cell.x) + layer);
}

// The dilation, as far as each penumbra reaches.
fn spread(cell: vec2u, layer: u32, lane: u32) {
    let count = atomicLoad(&cell_edges[layer].count);
    if count == 0u {
        return;
    }
    let reach = vec2i(vec2u(atomicLoad(&cell_edges[layer].reach_x), atomicLoad(&cell_edges[layer].reach_y)));
    let low = max(vec2i(cell) - reach, vec2i(0));
    let size = vec2u(min(vec2i(cell) + reach, vec2i(i32(cells_per_row()) - 1)) - low + 1);
    for (var i = lane; i < size.x * size.y; i += LANES) {
        let place = vec2u(low) + vec2u(i % size.x, i / size.x);
        let index = mask_index(place, layer);
        atomicAdd(&mask[index], atomicLoad(&cell_edges[layer].inverse_depth));
        atomicAdd(&mask[index + 1u], count);
    }
}

@compute @workgroup_size(CELL, CELL)
fn cs_mask(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) cell: vec3u,
) {
    if lane < layers {
        atomicStore(&cell_edges[lane].inverse_depth, 0u);
        atomicStore(&cell_edges[lane].count, 0u);
        atomicStore(&cell_edges[lane].reach_x, 0u);
        atomicStore(&cell_edges[lane].reach_y, 0u);
    }
    workgroupBarrier();
    if has_neighbours(id.xy) {
        let edge = edge_at(id.xy);
        if any(edge.half_width > vec2f(0.0)) {
            let reach = min(vec2u(edge.half_width / f32(CELL)) + 1u, vec2u(u32(WIDEST_CELLS)));
            let layer = layer_of_background(id.xy);
            atomicAdd(&cell_edges[layer].inverse_depth, u32(edge.inverse_depth / nearest_inverse_depth() * LEVELS));
            atomicAdd(&cell_edges[layer].count, 1u);
            atomicMax(&cell_edges[layer].reach_x, reach.x);
            atomicMax(&cell_edges[layer].reach_y, reach.y);
        }
    }
    workgroupBarrier();
    for (var layer = 0u; layer < layers; layer++) {
        spread(cell.xy, layer, lane);
    }
}

// Mean inverse depth of the layer's edges that reach the receiver's texel, 0 where none does; blended between the cells' centres, so that
// no kernel changes with a jump.
fn occluder_inverse_depth(map_sample: MapSample, layer: u32) -> f32 {
    let view = shadow_views[map_sample.view];
    let texel = vec2f(view.origin) + (map_sample.position - view.window_low) * view.texels_per_unit;
    let place = clamp(texel / f32(CELL) - 0.5, vec2f(0.0), vec2f(f32(cells_per_row() - 1u)));
    let low = vec2u(place);
    let weight = place - vec2f(low);
    var sum = vec2f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let corner = vec2u(i & 1u, i >> 1u);
        let cell = min(low + corner, vec2u(cells_per_row() - 1u));
        let share = select(1.0 - weight, weight, corner == vec2u(1u));
        let index = mask_index(cell, layer);
        sum += share.x * share.y * vec2f(f32(atomicLoad(&mask[index])), f32(atomicLoad(&mask[index + 1u])));
    }
    return select(0.0, sum.x / max(sum.y, 1e-6) / LEVELS * nearest_inverse_depth(), sum.y > 0.0);
}

fn masked_shadow(receiver: Receiver, map_sample: MapSample) -> f32 {
    let half_extent = penumbra_half_extent(occluder_inverse_depth(map_sample, layer_of_receiver(map_sample)) / map_sample.inverse_depth);
    let half_texels = half_extent * map_sample.inverse_depth * shadow_views[map_sample.view].texels_per_unit;
    if max(half_texels.x, half_texels.y) <= NARROWEST_TEXELS {
        return select(0.0, 1.0, map_sample_is_lit(map_sample));
    }
    return filter_shadow(receiver, half_extent, 0u, tap_count);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) workgroup: vec3u) {
    let pixel = begin_masked_pixel(id.xy, workgroup);
    if !pixel.is_masked {
        return;
    }
    visibility[pixel.receiver.index] = masked_shadow(pixel.receiver, pixel.map_sample);
    count_further_reads(workgroup);
}
