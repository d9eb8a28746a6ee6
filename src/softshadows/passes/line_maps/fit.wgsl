// Windows that all maps of a line light share, so that a row of one is the same row of every other.

//#include "../shadow_atlas/placing.wgsl"
//#include "line_space.wgsl"
//#struct LineWindow
//#struct LineState
//#struct Stage

@group(1) @binding(0) var<storage, read_write> line_windows: array<LineWindow, 6>;  // by face
@group(1) @binding(1) var<storage, read_write> state: LineState;
@group(1) @binding(2) var<storage, read> requests: array<u32>;  // by stage: its samples, as bits
@group(1) @binding(3) var<uniform> stage: Stage;

const LANES = 64u;
const VIEW_LIMIT = 1.0;    // faces meet at 45 degrees
const FRONT_LIMIT = 3.0;   // how far the front window may reach over the faces beside it, to 72 degrees
const FRONT_GROWTH = 3.0;  // by how much its area may grow for it: every face less is one drawing of the scene less
const OPPOSITE = 2u;
const BAND_SHARE = 0.0625;    // of the tile's edge, the least for a face in use
const NOTHING = vec3f(3e38);

// Extents from the line's first end, with u from its last end as z.
var<workgroup> lane_lows: array<vec3f, LANES>;
var<workgroup> lane_highs: array<vec3f, LANES>;
var<workgroup> lane_demands: array<vec2f, LANES>;  // sum of texels asked for per unit of the window, number of pixels

var<private> wanted: array<LineWindow, WINDOWS>;

struct LineExtent {
    low: vec3f,
    high: vec3f,
    depth: f32,
};

fn map_coordinates(face: u32, vector_ls: vec3f) -> vec3f {
    return line_face_coordinates(face, vector_ls);
}

fn nothing() -> LineExtent {
    return LineExtent(NOTHING, -NOTHING, 1.0);
}

// The part that a box of receivers takes of a face around the light, up to `limit` around it.
fn face_extent(face: u32, limit: f32, low_ls: vec3f, high_ls: vec3f) -> LineExtent {
    let corner_0 = line_face_coordinates(face, low_ls);
    let corner_1 = line_face_coordinates(face, high_ls);
    let low = min(corner_0, corner_1);
    let high = max(corner_0, corner_1);
    if high.z <= 0.0 {
        return nothing();
    }
    let beside = max(max(low.y, -high.y), 0.0);  // what lies beside the axis is in the face only where it is as deep
    let near = max(max(low.z, beside / limit), 1e-6 * high.z);
    let first = quotient_range(low.x + light.half_width, high.x + light.half_width, near, high.z);
    let last = quotient_range(low.x - light.half_width, high.x - light.half_width, near, high.z);
    let around = quotient_range(low.y, high.y, near, high.z);
    if around.x > limit || around.y < -limit || last.x > LINE_LIMIT || first.y < -LINE_LIMIT {
        return nothing();
    }
    let limits = vec3f(LINE_LIMIT, limit, LINE_LIMIT);
    return LineExtent(
        max(vec3f(first.x, around.x, last.x), -limits),
        min(vec3f(first.y, around.y, last.y), limits),
        0.5 * (near + high.z),
    );
}

// The part that it takes of a cap, seen from anywhere on the light.
fn cap_extent(face: u32, low_ls: vec3f, high_ls: vec3f) -> LineExtent {
    let corner_0 = line_face_coordinates(face, low_ls);
    let corner_1 = line_face_coordinates(face, high_ls);
    let low = min(corner_0, corner_1) - vec3f(0.0, 0.0, light.half_width);
    let high = max(corner_0, corner_1) + vec3f(0.0, 0.0, light.half_width);
    if high.z <= 0.0 {
        return nothing();
    }
    let limit = 1.0 / LINE_LIMIT;
    let near = max(low.z, 1e-6 * high.z);
    let across = quotient_range(low.x, high.x, near, high.z);
    let upward = quotient_range(low.y, high.y, near, high.z);
    if across.x > limit || across.y < -limit || upward.x > limit || upward.y < -limit {
        return nothing();
    }
    let inside_low = max(vec2f(across.x, upward.x), vec2f(-limit));
    let inside_high = min(vec2f(across.y, upward.y), vec2f(limit));
    return LineExtent(vec3f(inside_low, inside_low.x), vec3f(inside_high, inside_high.x), 0.5 * (near + high.z));
}

fn window_extent(window: u32, low_ls: vec3f, high_ls: vec3f) -> LineExtent {
    if window == WIDE_FRONT {
        return face_extent(FRONT, FRONT_LIMIT, low_ls, high_ls);
    }
    if window >= LINE_FACES {
        return cap_extent(window, low_ls, high_ls);
    }
    return face_extent(window, VIEW_LIMIT, low_ls, high_ls);
}

// One window for all samples. Seen from x along the line a window's low end is a concave, its high end a convex function of
// x, so that windows between those of the two ends hold what is to be seen from between; not where they are cut off.
fn shared_window(low: vec3f, high: vec3f, texels_per_unit: f32) -> LineWindow {
    if low.y > high.y {
        return LineWindow(vec2f(0.0), vec2f(-1.0), 0.0, 0.0);
    }
    var first = vec2f(low.x, high.x);
    var last = vec2f(low.z, high.z);
    if min(first.x, last.x) <= -LINE_LIMIT {
        first.x = -LINE_LIMIT;
        last.x = -LINE_LIMIT;
    }
    if max(first.y, last.y) >= LINE_LIMIT {
        first.y = LINE_LIMIT;
        last.y = LINE_LIMIT;
    }
    let extent = vec2f(max(first.y - first.x, last.y - last.x), high.y - low.y);
    return LineWindow(vec2f(first.x, low.y), extent, last.x - first.x, texels_per_unit);
}

fn is_absent(window: LineWindow) -> bool {
    return window.extent.y < 0.0;
}

// The windows of all faces around the receiver boxes, found by all lanes together.
fn find_wanted(lane: u32) {
    let beside = light.search_margin * vec3f(light.half_width, 0.0, 0.0);
    var lows: array<vec3f, WINDOWS>;
    var highs: array<vec3f, WINDOWS>;
    var demands: array<vec2f, WINDOWS>;
    for (var i = 0u; i < WINDOWS; i++) {
        lows[i] = NOTHING;
        highs[i] = -NOTHING;
    }
    for (var i = lane; i < light.box_count; i += LANES) {
        let box = receiver_boxes[i];
        if box.count == 0.0 {
            continue;
        }
        for (var window = 0u; window < WINDOWS; window++) {
            let extent = window_extent(window, box.low - beside, box.high + beside);
            if extent.low.y <= extent.high.y {
                lows[window] = min(lows[window], extent.low);
                highs[window] = max(highs[window], extent.high);
                demands[window] += vec2f(box.count * extent.depth / box.footprint, box.count);
            }
        }
    }
    for (var window = 0u; window < WINDOWS; window++) {
        lane_lows[lane] = lows[window];
        lane_highs[lane] = highs[window];
        lane_demands[lane] = demands[window];
        for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
            workgroupBarrier();
            if lane < stride {
                lane_lows[lane] = min(lane_lows[lane], lane_lows[lane + stride]);
                lane_highs[lane] = max(lane_highs[lane], lane_highs[lane + stride]);
                lane_demands[lane] += lane_demands[lane + stride];
            }
        }
        workgroupBarrier();
        let demand = light.texels_per_pixel * lane_demands[0].x / max(lane_demands[0].y, 1.0);
        wanted[window] = shared_window(lane_lows[0], lane_highs[0], demand);
        workgroupBarrier();
    }
}

// One wide window where it can hold what the faces beside it would, and does not waste too many texels.
fn join_into_front() {
    let front = wanted[FRONT].extent;
    let wide = wanted[WIDE_FRONT].extent;
    let above = wanted[1];  // v from -1, where the front ends; beyond -1 / limit the wide front does not reach
    let below = wanted[3];  // v up to 1
    let is_out_of_reach = (!is_absent(above) && above.low_first.y + above.extent.y > -1.0 / FRONT_LIMIT)
        || (!is_absent(below) && below.low_first.y < 1.0 / FRONT_LIMIT);
    if is_absent(wanted[FRONT]) || !is_absent(wanted[OPPOSITE]) || is_out_of_reach || wide.x * wide.y > FRONT_GROWTH * front.x * front.y {
        return;
    }
    wanted[FRONT] = wanted[WIDE_FRONT];
    wanted[1].extent = vec2f(-1.0);
    wanted[3].extent = vec2f(-1.0);
}

// The windows of the sample at `share` of the way along the line, in placing.wgsl's terms.
fn take_windows(share: f32) {
    for (var face = 0u; face < FACES; face++) {
        let window = wanted[face];
        let low = window.low_first + vec2f(share * window.drift, 0.0);
        windows[face] = Window(low, low + window.extent, window.texels_per_unit);
        if is_absent(window) {
            windows[face] = Window(EMPTY_LOW, EMPTY_HIGH, 0.0);
        }
    }
}

// Place the windows in the sample's tile as bands of its whole width, for they are wide along the light. A band is as high as the
// texels that its face asks for around the light.
fn place_bands(sample: u32) {
    var heights: array<f32, FACES>;
    var total = 0.0;
    var left = 0.0;  // bands still to be placed
    for (var face = 0u; face < FACES; face++) {
        if !is_empty(windows[face]) {
            heights[face] = max((windows[face].high.y - windows[face].low.y) * windows[face].texels_per_unit, 1.0);
            total += heights[face];
            left += 1.0;
        }
    }
    let tile = f32(light.tile_size);
    let smallest = BAND_SHARE * tile;
    let rest = tile - left * smallest;
    let first = vec2f(vec2u(sample % light.tiles_per_row, sample / light.tiles_per_row) * light.tile_size);
    var used = 0.0;
    for (var face = 0u; face < FACES; face++) {
        views[face] = ShadowView(vec2f(0.0), vec2f(0.0), vec2u(0u), vec2u(0u));
        if heights[face] > 0.0 {
            let height = select(floor(smallest + rest * heights[face] / total), tile - used, left == 1.0);
            views[face] = place(windows[face], first + vec2f(0.0, used), vec2f(tile, height));
            used += height;
            left -= 1.0;
        }
    }
}

// Do the maps of the last frame still show all that these windows would? The two ends speak for what is between them.
fn all_still_serve() -> bool {
    for (var end = 0u; end < 2u; end++) {
        take_windows(f32(end));
        let sample = end * (light.sample_count - 1u);
        place_bands(sample);
        if !still_serve(sample) {
            return false;
        }
    }
    return true;
}

fn widen_wanted() {
    for (var face = 0u; face < FACES; face++) {
        if !is_absent(wanted[face]) {
            wanted[face].low_first -= KEPT_ROOM * wanted[face].extent;
            wanted[face].extent *= 1.0 + 2.0 * KEPT_ROOM;
        }
    }
}

// The windows for this frame: those of the last one while they serve, so that its maps are kept.
@compute @workgroup_size(LANES)
fn cs_fit(@builtin(local_invocation_index) lane: u32) {
    find_wanted(lane);
    if lane != 0u {
        return;
    }
    join_into_front();
    state.drawn_now = 0u;
    if atomicLoad(&drawn_samples[0]) != 0u {
        if all_still_serve() {
            return;
        }
        widen_wanted();
        atomicStore(&drawn_samples[0], 0u);
    }
    for (var face = 0u; face < FACES; face++) {
        line_windows[face] = wanted[face];
    }
}

// Place and list the maps that the stage requests and the atlas does not hold.
@compute @workgroup_size(1)
fn cs_place() {
    for (var face = 0u; face < FACES; face++) {
        wanted[face] = line_windows[face];
    }
    for (var rest = requests[stage.number] & ~atomicLoad(&drawn_samples[0]); rest != 0u; rest &= rest - 1u) {
        let sample = firstTrailingBit(rest);
        take_windows(f32(sample) / f32(max(light.sample_count, 2u) - 1u));
        place_bands(sample);
        list_views(sample, stage.number);
        state.drawn_now |= 1u << sample;
    }
    atomicOr(&drawn_samples[0], requests[stage.number]);
}
