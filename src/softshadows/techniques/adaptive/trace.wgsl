// Ask about a batch's light samples once at every pixel whose tree requests them, by rays or, where maps know the answer, by
// them, and remember the answers as bits.

//#include "receiver.wgsl"
//#include "light_rays.wgsl"
//#include "known_by_map.wgsl"
//#include "remember.wgsl"

@group(3) @binding(5) var<storage, read> active_tiles: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;

fn remember_lit(tile: u32, lane: u32, sample: u32) {
    let row = sample / shape.columns;
    let column = sample % shape.columns;
    let is_17th = column == 16u;
    let word = mask_index(tile, select(row / 2u, mask_words() - 1u, is_17th), lane);
    masks[word] |= 1u << select(16u * (row % 2u) + column, row, is_17th);
}

fn trace_packet(tile: u32, lane: u32) {
    let is_open = open_segments(packet);
    for (var i = 0u; i < 4u; i++) {
        if is_open[i] {
            remember_lit(tile, lane, waiting[i]);
        }
    }
}

@compute @workgroup_size(TILE, TILE)
fn cs_trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let list_at = list_index(group);
    let count = control.levels[step.level].sample_count;
    if list_at >= atomicLoad(&control.levels[step.level].active_tiles) || step.first_rank >= count {
        return;
    }
    let tile = active_tiles[step.level * tile_count() + list_at];
    let pixel = tile_origin(tile) + local.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let surface = load_receiver(pixel);
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    let start = ray_start(surface.position_ws, surface.normal_ws);

    let first = control.ranked[step.first_rank];
    let last = control.ranked[min(step.first_rank + step.samples_per_batch, count) - 1u];
    let rows_apart = select(1u, spacing(step.level), shape.has_rows == 1u);
    begin_packet(start);
    for (var row = first / shape.columns; row <= last / shape.columns; row += rows_apart) {
        let requested = requested_samples(tree_of(tile), row, first, last);
        if requested != 0u {
            remember(tile, lane, row, requested, 0u);
        }
        for (var rest = select(0u, requested, surface.is_surface); rest != 0u; rest &= rest - 1u) {
            let sample = shape.columns * row + firstTrailingBit(rest);
            let ray = ray_to(start, light_samples[sample].xy);
            let answer = select(HIDDEN, map_answer(sample, receiver), can_see(start, ray));
            if answer == LIT {
                remember_lit(tile, lane, sample);
            } else if answer == UNKNOWN {
                add_to_packet(start, sample, ray);
            }
            if waiting_count == 4u {
                trace_packet(tile, lane);
                begin_packet(start);
            }
        }
    }
    if waiting_count > 0u {
        trace_packet(tile, lane);
    }
    if was_cut_short {
        atomicOr(&control.cut_short, 1u);
    }
}
