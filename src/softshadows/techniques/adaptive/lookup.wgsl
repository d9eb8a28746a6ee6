// Look a batch's light samples up once at every pixel whose tree requests them, and remember the answers as bits.

//#include "receiver.wgsl"
//#include "shadow_map.wgsl"
//#include "remember.wgsl"

@group(3) @binding(5) var<storage, read> active_tiles: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;

@compute @workgroup_size(TILE, TILE)
fn cs_lookup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
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

    // The batch's samples: in order, so all new ones that the tree requests between the first and the last.
    let first = control.ranked[step.first_rank];
    let last = control.ranked[min(step.first_rank + step.samples_per_batch, count) - 1u];
    let rows_apart = select(1u, spacing(step.level), shape.has_rows == 1u);
    for (var row = first / shape.columns; row <= last / shape.columns; row += rows_apart) {
        let requested = requested_samples(tree_of(tile), row, first, last);
        var visible = 0u;
        for (var rest = select(0u, requested, surface.is_surface); rest != 0u; rest &= rest - 1u) {
            let column = firstTrailingBit(rest);
            visible |= select(0u, 1u << column, sample_is_visible(shape.columns * row + column, receiver));
        }
        if requested != 0u {
            remember(tile, lane, row, requested, visible);
        }
    }
}
