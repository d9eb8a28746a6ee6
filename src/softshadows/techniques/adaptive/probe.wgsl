// Four rays from every pixel to places on the light that no other pixel of its tile looks at: together a tile probes every
// deepest cell of the light. What hides a small part of the light from all of a tile, between its few shared samples, shows here,
// and the tile refines the cells around it (refine.wgsl). Probes say where to look; they are no part of the visibility.

//#include "passes/gbuffer/receiver.wgsl"
//#include "visibility/rays/light_rays.wgsl"
//#include "tree.wgsl"
//#include "probes.wgsl"

@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(12) var<storage, read_write> probes: array<atomic<u32>>;

// A number that looks random, for every number (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020: pcg).
fn scattered(number: u32) -> u32 {
    let state = number * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// From 0 to 1, two of them from one number.
fn unit_pair(number: u32) -> vec2f {
    let bits = scattered(number);
    return (vec2f(vec2u(bits & 0xffffu, bits >> 16u)) + 0.5) / 65536.0;
}

// A place on the light, given from 0 to 1 along the lattice's columns and rows, in light space.
fn point_on_light(place: vec2f) -> vec2f {
    let along = 2.0 * place - 1.0;
    let extent = vec2f(light.half_width, light.half_height);
    let is_upright = shape.has_rows == 0u && light.half_width == 0.0;
    return extent * select(along, along.xx, is_upright);
}

@compute @workgroup_size(TILE, TILE)
fn cs_probe(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let list_at = list_index(group);
    if list_at >= atomicLoad(&control.levels[0].active_tiles) {
        return;
    }
    let tile = control.tile_lists[list_at];
    let pixel = tile_origin(tile) + local.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let receiver = load_receiver(pixel);
    if !receiver.is_surface {
        return;
    }
    // The tile's pixels share out the light's quarters of four cells, in another order in every tile.
    let start = ray_start(receiver);
    let turn = scattered(tile);
    let share = (lane * 37u + turn) % PIXELS;
    let cells = probed_cells();
    begin_packet(start);
    for (var i = 0u; i < 4u; i++) {
        let cell = (2u * vec2u(share % TILE, share / TILE) + vec2u(i % 2u, i / 2u)) % cells;
        let ray = ray_to(start, point_on_light((vec2f(cell) + unit_pair(turn ^ (4u * lane + i))) / vec2f(cells)));
        if can_see(start, ray) {
            add_to_packet(start, cell.y * DEEPEST_CELLS + cell.x, ray);
        } else {
            atomicOr(&probes[probe_index(tile, HIDDEN, cell.y)], 1u << cell.x);
        }
    }
    let is_unoccluded = trace_visibility(packet);
    for (var i = 0u; i < waiting_count; i++) {
        let row = waiting[i] / DEEPEST_CELLS;
        atomicOr(&probes[probe_index(tile, select(HIDDEN, LIT, is_unoccluded[i]), row)], 1u << (waiting[i] % DEEPEST_CELLS));
    }
}
