// On a line, an edge lies between a sample that is visible and the next one that is not. Four more rays between them find it
// five times as exactly as the trapezoid rule, which puts it in the middle. Before the average, which adds what changes.

//#include "visibility/rays/light_rays.wgsl"
//#include "lights/stratified.wgsl"
//#include "weights.wgsl"

@group(3) @binding(11) var<storage, read_write> visibility: array<f32>;

const PIECES = 5.0;  // of a cell, between its ends and four points

// What the cell between two samples adds to the average, as a share of the cell: by the rays, less what its ends gave.
fn correction(start: RayStart, pixel: vec2u, first: u32, last: u32) -> f32 {
    let begin = light_sample_for(pixel, first);
    let end = light_sample_for(pixel, last);
    begin_packet(start);
    for (var i = 1.0; i < PIECES; i += 1.0) {
        let ray = ray_to(start, mix(begin, end, i / PIECES));
        if can_see(start, ray) {
            add_to_packet(start, first, ray);
        }
    }
    let lit = dot(select(vec4f(0.0), vec4f(1.0), trace_visibility(packet)), vec4f(1.0));
    return (lit + 0.5) / PIECES - 0.5;
}

@compute @workgroup_size(TILE, TILE)
fn cs_bracket(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = tree_pixel(group.xy, local.xy);
    if !pixel.receiver.is_surface || !is_active(pixel.tree) {
        return;
    }
    let start = ray_start(pixel.receiver);
    let seen = row_bits(pixel.tile, 0u, lane);
    var change = 0.0;
    var rays = 0u;
    for (var level = 0u; level <= shape.deepest; level++) {
        let width = spacing(level);
        var mixed = leaf_cells(pixel.tree, level, 0u) & (seen ^ (seen >> width));
        for (; mixed != 0u; mixed &= mixed - 1u) {
            let first = firstTrailingBit(mixed);
            change += cell_area(level) * correction(start, pixel.place, first, first + width);
            rays += 4u;
        }
    }
    visibility[pixel.receiver.index] = change / cell_area(0u);
    atomicAdd(&control.bracket_rays, rays);
    if was_cut_short {
        atomicOr(&control.cut_short, 1u);
    }
}
