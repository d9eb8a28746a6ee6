// Look a batch's light samples up once at every pixel whose tree requests them, and remember the answers as bits.

//#include "shadow_map.wgsl"
//#include "batch.wgsl"

// Answers about the samples of a row replace what an earlier frame left about them.
fn remember(tile: u32, lane: u32, row: u32, requested: u32, visible: u32) {
    let pair = mask_index(tile, row / 2u, lane);
    let shift = 16u * (row % 2u);
    masks[pair] = (masks[pair] & ~((requested & 0xffffu) << shift)) | ((visible & 0xffffu) << shift);
    if (requested >> 16u) != 0u {
        let lasts = mask_index(tile, mask_words() - 1u, lane);
        masks[lasts] = insertBits(masks[lasts], visible >> 16u, row, 1u);
    }
}

// The bits of a row that stand for samples from `first` to `last`.
fn bits_between(row: u32, first: u32, last: u32) -> u32 {
    let low = select(0u, first % shape.columns, row == first / shape.columns);
    let high = select(31u, last % shape.columns, row == last / shape.columns);
    return (0xffffffffu << low) & (0xffffffffu >> (31u - high));
}

// The new samples of a row that a tree requests, of those from `first` to `last`.
fn requested_samples(tree: u32, row: u32, first: u32, last: u32) -> u32 {
    return requests[tree * shape.sample_rows + row] & new_samples(row) & bits_between(row, first, last);
}

@compute @workgroup_size(TILE, TILE)
fn cs_lookup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asked = batch_pixel(group, local);
    if !asked.is_asked {
        return;
    }
    let surface = load_receiver(asked.pixel);
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);

    // The batch's samples: in order, so all new ones that the tree requests between the first and the last.
    let first = control.ranked[step.first_rank];
    let last = control.ranked[batch_end() - 1u];
    let rows_apart = select(1u, spacing(step.level), shape.has_rows == 1u);
    for (var row = first / shape.columns; row <= last / shape.columns; row += rows_apart) {
        let requested = requested_samples(tree_of(asked.tile), row, first, last);
        var visible = 0u;
        for (var rest = select(0u, requested, surface.is_surface); rest != 0u; rest &= rest - 1u) {
            let column = firstTrailingBit(rest);
            visible |= select(0u, 1u << column, sample_is_visible(shape.columns * row + column, receiver));
        }
        if requested != 0u {
            remember(asked.tile, lane, row, requested, visible);
        }
    }
}
