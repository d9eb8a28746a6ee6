// Windows of the shadow maps: for each face of a light sample's cube, what holds the receivers that reach into it, and how many
// texels it asks for so that a texel is as large as a pixel at the receivers. The faces in use then share the sample's tile of
// the atlas, and join the list of views to draw (placing.wgsl).
//
// One workgroup of LANES fits a sample. The including file says by `is_receiver(box, sample)` whose boxes count.

//#needs is_receiver
//#include "placing.wgsl"
//#include "lanes.wgsl"

const WINDOW_LIMIT = 1.0;      // faces meet at 45 degrees
const FRONT_LIMIT = 3.0;       // how far the front window may reach over the other faces, to 72 degrees
const FRONT_GROWTH = 3.0;      // by how much its area may grow for it: every face less is one drawing of the scene less

fn map_coordinates(face: u32, vector_ls: vec3f) -> vec3f {
    return face_coordinates(face, vector_ls);
}

// The part of a window's plane that a box takes: low and high corner, and the mean depth of what is in it. Empty where the
// box lies beyond the window's limit.
struct Extent {
    low: vec2f,
    high: vec2f,
    depth: f32,
};

fn box_extent(face: u32, limit: f32, low_ls: vec3f, high_ls: vec3f) -> Extent {
    let corner_0 = face_coordinates(face, low_ls);
    let corner_1 = face_coordinates(face, high_ls);
    let low = min(corner_0, corner_1);
    let high = max(corner_0, corner_1);
    if light.is_directional == 1u {
        return Extent(low.xy, high.xy, 1.0);
    }
    if high.z <= 0.0 {
        return Extent(EMPTY_LOW, EMPTY_HIGH, 1.0);
    }
    let near = max(low.z, 1e-6 * high.z);
    let range_a = quotient_range(low.x, high.x, near, high.z);
    let range_b = quotient_range(low.y, high.y, near, high.z);
    if range_a.x > limit || range_a.y < -limit || range_b.x > limit || range_b.y < -limit {
        return Extent(EMPTY_LOW, EMPTY_HIGH, 1.0);
    }
    return Extent(max(vec2f(range_a.x, range_b.x), vec2f(-limit)), min(vec2f(range_a.y, range_b.y), vec2f(limit)), 0.5 * (near + high.z));
}

// The windows of all faces around the receiver boxes, found by all lanes together.
fn fit_windows(sample: u32, texels_per_pixel: f32, lane: u32) {
    let sample_ls = vec3f(light_samples.points[sample].xy, 0.0);
    let beside = maps.search_margin * vec3f(light.half_width, light.half_height, 0.0);
    let face_count = select(FACES, 1u, light.is_directional == 1u);
    var lows: array<vec2f, WINDOWS>;
    var highs: array<vec2f, WINDOWS>;
    var demands: array<vec2f, WINDOWS>;
    for (var i = 0u; i < WINDOWS; i++) {
        lows[i] = EMPTY_LOW;
        highs[i] = EMPTY_HIGH;
    }
    for (var i = lane; i < arrayLength(&receiver_boxes); i += LANES) {
        let box = receiver_boxes[i];
        if box.count == 0.0 || !is_receiver(i, sample) {
            continue;
        }
        for (var window = 0u; window < WINDOWS; window++) {
            let is_wide = window == WIDE_FRONT;
            if window >= face_count && !is_wide {
                continue;
            }
            let face = select(window, FRONT, is_wide);
            let extent = box_extent(face, select(WINDOW_LIMIT, FRONT_LIMIT, is_wide), box.low - beside - sample_ls, box.high + beside - sample_ls);
            if extent.low.x <= extent.high.x {
                lows[window] = min(lows[window], extent.low);
                highs[window] = max(highs[window], extent.high);
                demands[window] += vec2f(box.count * extent.depth / box.footprint, box.count);
            }
        }
    }
    for (var window = 0u; window < WINDOWS; window++) {
        join_lanes(lane, vec3f(lows[window], 0.0), vec3f(highs[window], 0.0), demands[window]);
        windows[window] = Window(lane_lows[0].xy, lane_highs[0].xy, texels_per_pixel * lane_demands[0].x / max(lane_demands[0].y, 1.0));
        workgroupBarrier();
    }
}

// Can the wide front window hold all that the other faces' windows hold?
fn front_can_hold() -> bool {
    let front = windows[FRONT];
    if is_empty(front) || !is_empty(windows[BACK]) {
        return false;
    }
    for (var face = 1u; face < BACK; face++) {
        // b = z / |axis| on the faces beside the front: -1 at the front's edge, -1 / limit at the wide front's.
        if !is_empty(windows[face]) && windows[face].high.y > -1.0 / FRONT_LIMIT {
            return false;
        }
    }
    let extent = front.high - front.low;
    let wide_extent = windows[WIDE_FRONT].high - windows[WIDE_FRONT].low;
    return wide_extent.x * wide_extent.y <= FRONT_GROWTH * extent.x * extent.y;
}

fn fit_sample(sample: u32, slot: Slot, lane: u32) {
    fit_windows(sample, slot.texels_per_pixel, lane);
    if lane != 0u {
        return;
    }

    // One wide window where it can hold everything and does not waste too many texels.
    if front_can_hold() {
        windows[FRONT] = windows[WIDE_FRONT];
        for (var face = 1u; face < FACES; face++) {
            windows[face].high = EMPTY_HIGH;
        }
    }

    // A map that is still there is kept while it serves. Where it may be looser, an outgrown one's successor gets room for what
    // comes next.
    let bit = 1u << (sample % 32u);
    let was_drawn = (atomicOr(&draws.drawn_samples[sample / 32u], bit) & bit) != 0u;
    for (var attempt = 0u; attempt < select(1u, 2u, was_drawn); attempt++) {
        if attempt == 1u && draws.keeps_looser_fits == 1u {
            widen_windows();
        }
        place_all(slot);
        if attempt == 0u && was_drawn && still_serve(sample) {
            return;
        }
    }
    list_views(sample, slot.chunk);
}
