// Windows that all maps of a line light share, so that a row of one is the same row of every other.

//#include "visibility/maps/placing.wgsl"
//#include "visibility/maps/lanes.wgsl"
//#include "visibility/swept_box.wgsl"
//#include "line_space.wgsl"
//#struct LineWindow
//#struct LineState
//#struct Stage
//#struct OccluderBox

@group(1) @binding(0) var<storage, read_write> line_windows: array<LineWindow, 6>;  // by face
@group(1) @binding(1) var<storage, read_write> state: LineState;
@group(1) @binding(2) var<storage, read> requests: array<u32>;  // by stage: its samples, as bits
@group(1) @binding(3) var<uniform> stage: Stage;
@group(1) @binding(4) var<storage, read> occluder_boxes: array<OccluderBox>;

const VIEW_LIMIT = 1.0;    // faces meet at 45 degrees
const FRONT_LIMIT = 3.0;   // how far the front window may reach over the faces beside it, to 72 degrees
const FRONT_GROWTH = 3.0;  // by how much its area may grow for it: every face less is one drawing of the scene less
const OPPOSITE = 2u;
const BAND_SHARE = 0.0625;    // of the tile's edge, the least for a face in use
const MOST_COLUMNS = 2u;
const ROW_WEIGHT = 2.0;  // of a texel's extent around the light, against that along it, where penumbrae are soft
const NOTHING = vec3f(3e38);
const OCCLUDER_ROOM = 0.01;  // of what occluders take: their edges need texels on both sides

// Extents are from the line's first end, with u from its last end as z.
var<private> wanted: array<LineWindow, WINDOWS>;
var<private> lows: array<vec3f, WINDOWS>;
var<private> highs: array<vec3f, WINDOWS>;
var<private> demands: array<vec2f, WINDOWS>;
var<private> limit_lows: array<vec2f, WINDOWS>;
var<private> limit_highs: array<vec2f, WINDOWS>;

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

// A window's upper ends, as the line's two ends see them, cut off at a limit: both, or neither where that takes less room.
//
// Seen from x along the line an upper end is a convex function of x, so that a line between those of the line's ends holds
// what is to be seen from between them; a function that is cut off on the way is not. Boxes are cut off at LINE_LIMIT.
fn cut_off(ends: vec2f, limit: f32) -> vec2f {
    let highest = max(ends.x, ends.y);
    let waste = limit - min(ends.x, ends.y);
    let is_cut = highest > limit && (highest - limit > waste || highest >= LINE_LIMIT);
    return select(ends, vec2f(limit), is_cut);
}

// One window for all samples, around the receivers and within the limits, what occluders take of the face.
fn shared_window(low: vec3f, high: vec3f, limit_low: vec2f, limit_high: vec2f, texels_per_unit: f32) -> LineWindow {
    let low_v = max(low.y, limit_low.y);
    let high_v = min(high.y, limit_high.y);
    let lower = -cut_off(-low.xz, -limit_low.x);
    let upper = cut_off(high.xz, limit_high.x);
    let first = vec2f(lower.x, upper.x);
    let last = vec2f(lower.y, upper.y);
    let extent = vec2f(max(first.y - first.x, last.y - last.x), high_v - low_v);
    if low.y > high.y || any(extent < vec2f(0.0)) {
        return LineWindow(vec2f(0.0), vec2f(-1.0), 0.0, 0.0);
    }
    return LineWindow(vec2f(first.x, low_v), extent, last.x - first.x, texels_per_unit);
}

fn is_absent(window: LineWindow) -> bool {
    return window.extent.y < 0.0;
}

// What the occluders take of every face that may shadow a receiver in the box [low, high], seen from anywhere on the light: a
// point that some sample does not see lies there in all maps. The rest of a map is lit, and needs no texels.
fn bound_occluders(lane: u32, low_ls: vec3f, high_ls: vec3f) {
    let light_reach = vec3f(light.half_width, 0.0, 0.0);
    for (var i = 0u; i < WINDOWS; i++) {
        lows[i] = NOTHING;
        highs[i] = -NOTHING;
    }
    for (var i = lane; i < arrayLength(&occluder_boxes); i += LANES) {
        let box = occluder_boxes[i];
        let center = to_light_space(light, 0.5 * (box.low_ws + box.high_ws) - light.center_ws);
        let half = 0.5 * (box.high_ws - box.low_ws);
        let reach = vec3f(dot(abs(light.right_ws), half), dot(abs(light.up_ws), half), dot(abs(light.back_ws), half));
        if !can_shadow(center - reach, center + reach, low_ls, high_ls, -light_reach, light_reach) {
            continue;
        }
        for (var window = 0u; window < WINDOWS; window++) {
            let extent = window_extent(window, center - reach, center + reach);
            lows[window] = min(lows[window], extent.low);
            highs[window] = max(highs[window], extent.high);
        }
    }
    for (var window = 0u; window < WINDOWS; window++) {
        join_lanes(lane, lows[window], highs[window], vec2f(0.0));
        let room = OCCLUDER_ROOM * max(lane_highs[0] - lane_lows[0], vec3f(0.0));
        limit_lows[window] = vec2f(min(lane_lows[0].x, lane_lows[0].z), lane_lows[0].y) - room.xy;
        limit_highs[window] = vec2f(max(lane_highs[0].x, lane_highs[0].z), lane_highs[0].y) + room.xy;
        if window < LINE_FACES || window == WIDE_FRONT {
            limit_lows[window].x = max(limit_lows[window].x, -LINE_LIMIT);
            limit_highs[window].x = min(limit_highs[window].x, LINE_LIMIT);
        }
        workgroupBarrier();
    }
}

// The windows of all faces around the receiver boxes, found by all lanes together.
fn find_wanted(lane: u32) {
    let beside = maps.search_margin * vec3f(light.half_width, 0.0, 0.0);
    var low_ls = NOTHING;
    var high_ls = -NOTHING;
    for (var i = lane; i < arrayLength(&receiver_boxes); i += LANES) {
        if receiver_boxes[i].count > 0.0 {
            low_ls = min(low_ls, receiver_boxes[i].low);
            high_ls = max(high_ls, receiver_boxes[i].high);
        }
    }
    join_lanes(lane, low_ls, high_ls, vec2f(0.0));
    low_ls = lane_lows[0];
    high_ls = lane_highs[0];
    workgroupBarrier();
    for (var i = 0u; i < WINDOWS; i++) {
        limit_lows[i] = vec2f(-LINE_LIMIT);
        limit_highs[i] = vec2f(LINE_LIMIT);
    }
    if light.half_width > 0.0 {  // without a length, the shadow is to be that of `hard`
        bound_occluders(lane, low_ls, high_ls);
    }

    for (var i = 0u; i < WINDOWS; i++) {
        lows[i] = NOTHING;
        highs[i] = -NOTHING;
        demands[i] = vec2f(0.0);
    }
    for (var i = lane; i < arrayLength(&receiver_boxes); i += LANES) {
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
        join_lanes(lane, lows[window], highs[window], demands[window]);
        let demand = maps.texels_per_pixel * lane_demands[0].x / max(lane_demands[0].y, 1.0);
        wanted[window] = shared_window(lane_lows[0], lane_highs[0], limit_lows[window], limit_highs[window], demand);
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

// By how many rows a sample's maps are shifted against the middle one's: an edge along the light, which all of them see in
// one row, is not moved to a row's border by all of them, but by each to another place. Neighbours differ by less than half
// a row. Two maps are the papers' and keep the same rows; without a length, all samples are one.
fn row_shift(sample: u32) -> f32 {
    if light_samples.count < 3u || light.half_width == 0.0 {
        return 0.0;
    }
    return (f32(sample) + 0.5) / f32(light_samples.count) - 0.5;
}

// Place the windows in the sample's tile as bands, for they are wide along the light, in one column or two. A band is as high
// as the texels that its face asks for around the light.
fn place_bands(sample: u32, columns: u32) {
    var heights: array<f32, FACES>;
    var column_of: array<u32, FACES>;
    var totals: array<f32, MOST_COLUMNS>;
    var left: array<f32, MOST_COLUMNS>;  // bands still to be placed
    for (var face = 0u; face < FACES; face++) {
        if is_empty(windows[face]) {
            continue;
        }
        heights[face] = max((windows[face].high.y - windows[face].low.y) * windows[face].texels_per_unit, 1.0);
        let column = select(0u, 1u, columns == 2u && totals[1] < totals[0]);
        column_of[face] = column;
        totals[column] += heights[face];
        left[column] += 1.0;
    }
    let tile = f32(maps.tile_size);
    let width = 2.0 * floor(0.5 * tile / f32(columns));  // even: a technique may keep texels by twos
    let first = vec2f(vec2u(sample % maps.tiles_per_row, sample / maps.tiles_per_row) * maps.tile_size);
    let smallest = BAND_SHARE * tile;
    let rests = tile - smallest * vec2f(left[0], left[1]);
    var used: array<f32, MOST_COLUMNS>;
    for (var face = 0u; face < FACES; face++) {
        views[face] = ShadowView(vec2f(0.0), vec2f(0.0), vec2u(0u), vec2u(0u));
        if heights[face] == 0.0 {
            continue;
        }
        let column = column_of[face];
        let share = heights[face] / totals[column];
        let height = select(floor(smallest + rests[column] * share), tile - used[column], left[column] == 1.0);
        let origin = first + vec2f(f32(column) * width, used[column]);
        views[face] = place(windows[face], origin, vec2f(width, height));
        views[face].window_low.y += row_shift(sample) / views[face].texels_per_unit.y;
        used[column] += height;
        left[column] -= 1.0;
    }
}

// How coarse the placed views are for what they are asked.
fn coarseness() -> f32 {
    var sum = 0.0;
    for (var face = 0u; face < FACES; face++) {
        if views[face].size.x > 0u {
            sum += windows[face].texels_per_unit * dot(vec2f(1.0, ROW_WEIGHT), 1.0 / views[face].texels_per_unit);
        }
    }
    return sum;
}

// Two columns where many faces share a tile, so that their bands are not too flat.
fn best_columns() -> u32 {
    take_windows(0.0);
    place_bands(0u, 1u);
    let of_one = coarseness();
    place_bands(0u, MOST_COLUMNS);
    return select(1u, MOST_COLUMNS, coarseness() < of_one);
}

// Are the windows, and how they share a tile, those of the last frame?
fn all_are_unchanged(columns: u32) -> bool {
    for (var face = 0u; face < FACES; face++) {
        let had = line_windows[face];
        if any(wanted[face].low_first != had.low_first) || any(wanted[face].extent != had.extent)
            || wanted[face].drift != had.drift || wanted[face].texels_per_unit != had.texels_per_unit {
            return false;
        }
    }
    return columns == state.columns;
}

// Do the maps of the last frame still show all that these windows would? The two ends speak for what is between them.
fn all_still_serve(columns: u32) -> bool {
    if draws.keeps_looser_fits == 0u {
        return all_are_unchanged(columns);
    }
    for (var end = 0u; end < 2u; end++) {
        take_windows(f32(end));
        let sample = end * (light_samples.count - 1u);
        place_bands(sample, columns);
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

// The windows for this frame: those of the last one while they serve, so that its maps are cached.
@compute @workgroup_size(LANES)
fn cs_fit(@builtin(local_invocation_index) lane: u32) {
    find_wanted(lane);
    if lane != 0u {
        return;
    }
    join_into_front();
    let columns = best_columns();
    state.drawn_now = 0u;
    if atomicLoad(&draws.drawn_samples[0]) != 0u {
        if all_still_serve(columns) {
            return;
        }
        if draws.keeps_looser_fits == 1u {
            widen_wanted();
        }
        atomicStore(&draws.drawn_samples[0], 0u);
    }
    state.columns = columns;
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
    for (var rest = requests[stage.number] & ~atomicLoad(&draws.drawn_samples[0]); rest != 0u; rest &= rest - 1u) {
        let sample = firstTrailingBit(rest);
        take_windows(f32(sample) / f32(max(light_samples.count, 2u) - 1u));
        place_bands(sample, state.columns);
        list_views(sample, stage.number);
        state.drawn_now |= 1u << sample;
    }
    atomicOr(&draws.drawn_samples[0], requests[stage.number]);
}
