// Ask rays about a level's light samples at every pixel whose tree requests them, or after maps about those that they are not
// certain about, and remember the answers as bits.

//#include "visibility/rays/light_rays.wgsl"
//#include "lights/stratified.wgsl"
//#include "batch.wgsl"

override follows_maps: bool;

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

// The samples of a row that are left to ask, of all rows one after the other.
fn left_in(tile: u32, row: u32, lane: u32) -> u32 {
    if row >= shape.sample_rows {
        return 0u;
    }
    let requested = requested_samples(tile, row);
    if follows_maps {
        return requested & row_bits(unknown_by(tile), row, lane);
    }
    return requested;
}

@compute @workgroup_size(TILE, TILE)
fn cs_trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let asked = level_pixel(group, local);
    if !asked.is_asked {
        return;
    }
    let receiver = load_receiver(asked.pixel);
    let start = ray_start(receiver);
    if !follows_maps && step.first_ray == 0u {
        for (var row = 0u; row < shape.sample_rows; row++) {
            remember(asked.tile, lane, row, requested_samples(asked.tile, row), 0u);
        }
    }
    // Each pixel counts its own rays, so that packets are full, and neighbours trace theirs at the same time.
    var row = 0u;
    var left = left_in(asked.tile, row, lane);
    var earlier = step.first_ray;
    while row < shape.sample_rows && earlier >= countOneBits(left) {
        earlier -= countOneBits(left);
        row += 1u;
        left = left_in(asked.tile, row, lane);
    }
    for (; earlier > 0u; earlier--) {
        left &= left - 1u;
    }
    var rays = select(0u, step.rays, receiver.is_surface);
    while rays > 0u && row < shape.sample_rows {
        begin_packet(start);
        while rays > 0u && row < shape.sample_rows && waiting_count < 4u {
            for (; rays > 0u && left != 0u && waiting_count < 4u; left &= left - 1u) {
                let sample = shape.columns * row + firstTrailingBit(left);
                let ray = ray_to(start, light_sample_for(asked.pixel, sample));
                if can_see(start, ray) {
                    add_to_packet(start, sample, ray);
                }
                rays -= 1u;
            }
            while left == 0u && row < shape.sample_rows {
                row += 1u;
                left = left_in(asked.tile, row, lane);
            }
        }
        let is_unoccluded = trace_visibility(packet);
        for (var i = 0u; i < waiting_count; i++) {
            let place = place_of(asked.tile, lane, waiting[i]);
            visibility_bits[place.word] |= select(0u, place.bit, is_unoccluded[i]);
        }
    }
    if was_cut_short {
        atomicOr(&control.cut_short, 1u);
    }
}
