// Look a batch's light samples up once at every pixel whose tree requests them, and remember the answers as bits; where rays
// come after, also which samples the maps are not certain about.

//#include "visibility/maps/shadow_map.wgsl"
//#include "visibility/hybrid.wgsl"
//#include "batch.wgsl"

override leaves_unknown: bool;

// Samples that the level asks about, and the end of those in the batch.
fn level_samples() -> u32 {
    return control.levels[step.level].sample_count;
}

fn batch_end() -> u32 {
    return min(step.first_rank + step.samples_per_batch, level_samples());
}

// The bits of a row that stand for samples from `first` to `last`.
fn bits_between(row: u32, first: u32, last: u32) -> u32 {
    let low = select(0u, first % shape.columns, row == first / shape.columns);
    let high = select(31u, last % shape.columns, row == last / shape.columns);
    return (0xffffffffu << low) & (0xffffffffu >> (31u - high));
}

fn answer_of(sample: u32, receiver: Receiver) -> u32 {
    if leaves_unknown {
        return classify_by_map(sample, receiver);
    }
    return select(HIDDEN, LIT, sample_is_visible(sample, receiver));
}

@compute @workgroup_size(TILE, TILE)
fn cs_lookup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asked = level_pixel(group, local);
    if !asked.is_asked || step.first_rank >= level_samples() {
        return;
    }
    let receiver = seen_by(light, load_receiver(asked.pixel));

    // The batch's samples: in order, so all new ones that the tree requests between the first and the last.
    let first = control.ranked[step.first_rank];
    let last = control.ranked[batch_end() - 1u];
    let rows_apart = select(1u, spacing(step.level), shape.has_rows == 1u);
    for (var row = first / shape.columns; row <= last / shape.columns; row += rows_apart) {
        let requested = requested_samples(asked.tile, row) & bits_between(row, first, last);
        var visible = 0u;
        var unknown = 0u;
        for (var rest = select(0u, requested, receiver.is_surface); rest != 0u; rest &= rest - 1u) {
            let column = firstTrailingBit(rest);
            let answer = answer_of(shape.columns * row + column, receiver);
            visible |= select(0u, 1u << column, answer == LIT);
            unknown |= select(0u, 1u << column, answer == UNKNOWN);
        }
        if requested != 0u {
            remember(asked.tile, lane, row, requested, visible);
            if leaves_unknown {
                remember(unknown_by(asked.tile), lane, row, requested, unknown);
            }
        }
    }
}
