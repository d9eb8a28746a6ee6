// Ask about a batch's light samples once at every pixel whose tree requests them, by rays or, where maps know the answer, by
// them, and remember the answers as bits.

//#include "light_rays.wgsl"
//#include "sample_places.wgsl"
//#include "known_by_map.wgsl"
//#include "batch.wgsl"

// A sample's bit among the pixel's answers, and the word that holds it (tree.wgsl mask_index()).
struct Place {
    word: u32,
    bit: u32,
};

fn place_of(tile: u32, lane: u32, sample: u32) -> Place {
    let row = sample / shape.columns;
    let column = sample % shape.columns;
    let is_17th = column == 16u;
    let word = mask_index(tile, select(row / 2u, mask_words() - 1u, is_17th), lane);
    return Place(word, 1u << select(16u * (row % 2u) + column, row, is_17th));
}

fn is_requested(tree_index: u32, sample: u32) -> bool {
    return ((requests[tree_index * shape.sample_rows + sample / shape.columns] >> (sample % shape.columns)) & 1u) == 1u;
}

@compute @workgroup_size(TILE, TILE)
fn cs_trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asked = batch_pixel(group, local);
    if !asked.is_asked {
        return;
    }
    let surface = load_receiver(asked.pixel);
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    let start = ray_start(surface.position_ws, surface.normal_ws);

    // First what maps know, and which samples of the batch are left to ask: then pixels trace their packets in step.
    let ranks = batch_end() - step.first_rank;
    var unknown = 0u;
    for (var i = 0u; i < ranks; i++) {
        let sample = control.ranked[step.first_rank + i];
        if !is_requested(tree_of(asked.tile), sample) {
            continue;
        }
        let can_be_seen = surface.is_surface && can_see(start, ray_to(start, light_sample_for(asked.pixel, sample)));
        let answer = select(HIDDEN, map_answer(sample, receiver), can_be_seen);
        let place = place_of(asked.tile, lane, sample);
        masks[place.word] = (masks[place.word] & ~place.bit) | select(0u, place.bit, answer == LIT);
        unknown |= select(0u, 1u << i, answer == UNKNOWN);
    }
    while unknown != 0u {
        begin_packet(start);
        for (; unknown != 0u && waiting_count < 4u; unknown &= unknown - 1u) {
            let sample = control.ranked[step.first_rank + firstTrailingBit(unknown)];
            add_to_packet(start, sample, ray_to(start, light_sample_for(asked.pixel, sample)));
        }
        let is_open = open_segments(packet);
        for (var i = 0u; i < 4u; i++) {
            let place = place_of(asked.tile, lane, waiting[i]);
            masks[place.word] |= select(0u, place.bit, is_open[i]);
        }
    }
    if was_cut_short {
        atomicOr(&control.cut_short, 1u);
    }
}
