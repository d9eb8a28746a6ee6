// Variable penumbra by bands: edges of the shadow map, quantised by their strength and dilated, say where to filter and how wide.
//
// The mask has a bit per band, and with two layers of the map as many for each. The mip chain is not built: with values clamped to 1, a texel of level l is the union of the
// 2^l × 2^l texels under it, and a bilinear fetch of it that of four such texels, whose weights are never 0. So an edge knows
// which texels of the dilated mask it reaches, and sets them; all texels of a cell, 2^(l - 1) to a side, hold the same.

//#include "edges.wgsl"
//#include "visibility/maps/texel_filter.wgsl"

override blue_edge: f32;   // of the map's depth
override green_edge: f32;
override red_edge: f32;
override blue_level: u32;  // of the mip chain
override green_level: u32;
override red_level: u32;
override cell_bits: u32;   // log2 of the texels along a cell of the mask
override blue_kernel: u32;
override green_kernel: u32;
override red_kernel: u32;

const BLUE = 1u;
const GREEN = 2u;
const RED = 4u;
const BANDS = 3u;

// Depth in metres along the map's axis, from wherever.
fn axis_depth(inverse_depth: f32) -> f32 {
    return select(1.0 / inverse_depth, inverse_depth * (maps.near - maps.far), light.is_directional == 1u);
}

// [Evans2014 Eq. 1] [Evans2014 Eq. 2] How far the neighbours lie before the texel, as a share of what the map spans: the positive
// side of the Laplacian of depth, which is the background's. Where nothing was drawn, depth is the map's farthest.
fn edge_strength(texel: vec2u) -> f32 {
    let farthest = farthest_inverse_depth();
    let depth = axis_depth(max(texel_inverse_depth(texel), farthest));
    var sum = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            if is_neighbour(vec2i(x, y)) {
                sum += depth - axis_depth(max(texel_inverse_depth(vec2u(vec2i(texel) + vec2i(x, y))), farthest));
            }
        }
    }
    let extent = max(axis_depth(farthest) - axis_depth(nearest_inverse_depth()), 1e-20);
    return sum / (straight_edge_neighbours() * extent);
}

// [Evans2014 §4.4] The band of an edge, as a bit; 0 for none.
fn band_of(strength: f32) -> u32 {
    if strength > red_edge {
        return RED;
    }
    if strength > green_edge {
        return GREEN;
    }
    return select(0u, BLUE, strength > blue_edge);
}

fn level_of(band: u32) -> u32 {
    return select(select(blue_level, green_level, band == GREEN), red_level, band == RED);
}

fn cells_per_row() -> u32 {
    return ((maps.atlas_size - 1u) >> cell_bits) + 1u;
}

// [Evans2014 §4.3] Mip-chain dilation: of level l, the half texels from one before the edge's to one behind it.
fn dilate(texel: vec2u, band: u32) {
    let bit = band << (BANDS * layer_of_background(texel));
    let level = level_of(band);
    let half_texel_cells = 1i << (level - 1u - cell_bits);
    let parent = vec2i(texel >> vec2u(level));
    let low = max((2 * parent - 1) * half_texel_cells, vec2i(0));
    let high = min((2 * parent + 3) * half_texel_cells, vec2i(i32(cells_per_row())));
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            let cell = u32(y) * cells_per_row() + u32(x);
            if (atomicLoad(&mask[cell]) & bit) == 0u {
                atomicOr(&mask[cell], bit);
            }
        }
    }
}

@compute @workgroup_size(8, 8)
fn cs_mask(@builtin(global_invocation_id) id: vec3u) {
    let band = band_of(edge_strength(id.xy));
    if band != 0u && has_neighbours(id.xy) {  // last, as few texels are edges
        dilate(id.xy, band);
    }
}

// [Evans2014 §4.4] The kernel of the strongest band: taps in a row, and the first of them.
fn kernel_of(bands: u32) -> vec2u {
    if (bands & RED) != 0u {
        return vec2u(red_kernel, blue_kernel * blue_kernel + green_kernel * green_kernel);
    }
    if (bands & GREEN) != 0u {
        return vec2u(green_kernel, blue_kernel * blue_kernel);
    }
    return vec2u(blue_kernel, 0u);
}

// The bands that the mask holds for the receiver.
fn bands_around(map_sample: MapSample) -> u32 {
    let cell = (shadow_views[map_sample.view].origin + covering_texel(map_sample)) >> vec2u(cell_bits);
    let bits = atomicLoad(&mask[cell.y * cells_per_row() + cell.x]);
    let of_last = bits & (RED | GREEN | BLUE);
    let of_others = bits >> BANDS;
    if of_last == of_others {
        return of_last;
    }
    return select(of_last, of_others, layer_of_receiver(map_sample) == 1u);
}

// [Evans2014 §4.3] One tap where the mask is 0, PCF where it is not.
fn masked_shadow(map_sample: MapSample) -> f32 {
    let bands = bands_around(map_sample);
    if bands == 0u {
        return select(0.0, 1.0, map_sample_is_lit(map_sample));
    }
    let kernel = kernel_of(bands);
    return lit_share(map_sample, kernel.y, kernel.x * kernel.x, 0.5 * f32(kernel.x));
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) workgroup: vec3u) {
    let pixel = begin_masked_pixel(id.xy, workgroup);
    if !pixel.is_masked {
        return;
    }
    visibility[pixel.receiver.index] = masked_shadow(pixel.map_sample);
    count_further_reads(workgroup);
}
