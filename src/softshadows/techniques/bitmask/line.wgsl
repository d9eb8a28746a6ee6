// All samples of a line light at once, in place of a rectangle's: one row, its samples by 32 in words.
//
// Light space is turned about the line until the receiver lies right before it: x along the light, y across, z towards it. A
// triangle hides the samples between the two crossings of its outline with the plane of receiver and line, y = 0.

//#include "receiver_view.wgsl"
//#include "hidden_samples.wgsl"
//#needs Corners

const CLOSE = 1e-18;      // metres
const PROJECTED = 256.0;  // lifts before receiver and light from which on a triangle's picture is exact enough
const EDGE_ROOM = 1e-3;   // columns: more than float32 loses on the way of a box to the light

struct View {
    origin: vec3f,
    place: vec3f,
    towards: vec2f,   // unit, in light space's y and z, from the receiver to the line
    normal: vec3f,
    height: f32,      // of the line above the receiver
    lift: f32,
    nearest: f32,
    t_max: f32,
    columns: f32,     // per metre
    first_column: f32,  // at the light's middle
    last_word: f32,     // of this walk
    solid_count: u32,   // triangles of solids, of which the far side alone marks
    opaque_count: u32,  // triangles before those with an alpha mask
    grid_low: vec3f,    // of the tree's boxes, in light space
    grid_cell: vec3f,
};

fn turned(towards: vec2f, vector: vec3f) -> vec3f {
    return vec3f(vector.x, vector.y * towards.y - vector.z * towards.x, vector.y * towards.x + vector.z * towards.y);
}

fn view_of(receiver: LiftedReceiver, shift: vec2f) -> View {
    var view: View;
    let distance = max(length(receiver.origin.yz), CLOSE);
    view.origin = receiver.origin;
    view.place = receiver.place;
    view.towards = -receiver.origin.yz / distance;
    view.normal = turned(view.towards, receiver.normal);
    view.height = distance;
    view.lift = receiver.lift;
    view.nearest = PROJECTED * receiver.lift;
    view.t_max = 1.0 - receiver.light_lift / view.height;
    view.columns = 0.5 * COLUMNS * row_set.rows / light.half_width;
    view.first_column = 0.5 * COLUMNS * row_set.rows - COLUMNS * row_set.first_row - shift.x;
    view.last_word = row_set.count - 1.0;
    view.solid_count = light_tree.solid_count;
    view.opaque_count = light_tree.opaque_count;
    view.grid_low = light_tree.low_ws;
    view.grid_cell = 1.0 / light_tree.cells_per_metre;
    return view;
}

fn corner_from(view: View, corner: vec3f) -> vec3f {
    return turned(view.towards, corner - view.place);
}

fn column_at(view: View, x: vec3f) -> vec3f {
    return (x + view.origin.x) * view.columns + view.first_column;
}

// The bits of words between two columns of the row.
fn bits_of_words(words: vec4f, left: f32, right: f32) -> vec4u {
    return bits_between(left - COLUMNS * words, right - COLUMNS * words);
}

fn may_hide(view: View, box: vec4u) -> bool {
    let low_ls = view.grid_low + box_low(box) * view.grid_cell;
    let high_ls = view.grid_low + box_high(box) * view.grid_cell;
    let middle = corner_from(view, 0.5 * (low_ls + high_ls));
    let half = 0.5 * (high_ls - low_ls);
    let turn = abs(view.towards);
    let half_turned = vec3f(half.x, half.y * turn.y + half.z * turn.x, half.y * turn.x + half.z * turn.y);
    let low = middle - half_turned;
    let high = middle + half_turned;
    let is_above = dot(view.normal, middle) + dot(abs(view.normal), half_turned) > 0.0;
    let room = EDGE_ROOM * half_turned.y;
    let is_between = high.z > 0.0 && low.z < view.height && low.y <= room && high.y >= -room;
    let scale_near = view.height / max(low.z, CLOSE);
    let scale_far = max(view.height / max(high.z, CLOSE), 1.0);
    let ends = column_at(view, vec3f(min(low.x * scale_near, low.x * scale_far), max(high.x * scale_near, high.x * scale_far), 0.0));
    let left = clamp(ends.x - EDGE_ROOM, -1.0, 1e6);
    let right = clamp(ends.y + EDGE_ROOM, -1.0, 1e6);
    var open = bits_of_words(LOWER_WORDS, left, right) & ~hidden_lower;
    if has_upper_words {
        open |= bits_of_words(UPPER_WORDS, left, right) & ~hidden_upper;
    }
    return is_above && is_between && any(open != NONE);
}

// The part of the row between crossings: left, right.
fn with_edge(part: vec2f, start: vec2f, end: vec2f) -> vec2f {
    let is_rising = start.y <= end.y;
    let low = select(end, start, is_rising);
    let high = select(start, end, is_rising);
    let place = low.x - low.y * ((high.x - low.x) / (high.y - low.y));
    let is_crossed = low.y <= 0.0 && high.y > 0.0;
    return select(part, vec2f(min(part.x, place), max(part.y, place)), is_crossed);
}

// What a triangle hides of the row, in columns, and the words that it touches.
struct Picture {
    part: vec2f,
    first: f32,
    last: f32,
};

fn picture_of(view: View, corners: Corners) -> Picture {
    let scale = view.height / vec3f(corners.a.z, corners.b.z, corners.c.z);
    let column = column_at(view, vec3f(corners.a.x, corners.b.x, corners.c.x) * scale);
    let across = vec3f(corners.a.y, corners.b.y, corners.c.y) * scale;
    var part = vec2f(1e9, -1e9);
    part = with_edge(part, vec2f(column.x, across.x), vec2f(column.y, across.y));
    part = with_edge(part, vec2f(column.y, across.y), vec2f(column.z, across.z));
    part = with_edge(part, vec2f(column.z, across.z), vec2f(column.x, across.x));
    let words = floor(clamp(part / COLUMNS, vec2f(0.0, -1.0), vec2f(view.last_word + 1.0, view.last_word)));
    return Picture(part, words.x, words.y);
}

fn bits_in_picture(view: View, picture: Picture, word: f32) -> u32 {
    return bits_of_words(vec4f(word), picture.part.x, picture.part.y).x;
}

fn edge_plane(start: vec3f, end: vec3f) -> vec3f {
    return cross(end + start, start - end);
}

fn with_plane(part: vec2f, view: View, plane: vec3f, offset: f32) -> vec2f {
    let slope = plane.x / view.columns;
    let safe_slope = select(slope, 1e-30, slope == 0.0);
    let at_start = plane.x * (-view.first_column / view.columns - view.origin.x) + plane.z * view.height - offset;
    let place = -at_start / safe_slope;
    let is_rising = safe_slope > 0.0;
    return vec2f(max(part.x, select(-1e9, place, is_rising)), min(part.y, select(place, 1e9, is_rising)));
}

// What lies between planes, in columns.
struct Planes {
    part: vec2f,
};

fn planes_of(view: View, corners: Corners) -> Planes {
    let normal = cross(corners.c - corners.a, corners.a - corners.b);
    let volume = dot(normal, corners.a);
    let side = select(-1.0, 1.0, volume >= 0.0);
    var part = vec2f(-1e9, 1e9);
    part = with_plane(part, view, side * edge_plane(corners.c, corners.b), 0.0);
    part = with_plane(part, view, side * edge_plane(corners.a, corners.c), 0.0);
    part = with_plane(part, view, side * edge_plane(corners.b, corners.a), 0.0);
    part = with_plane(part, view, side * normal * view.t_max, abs(volume));
    return Planes(part);
}

fn bits_behind_planes(planes: Planes, word: f32) -> u32 {
    return bits_of_words(vec4f(word), planes.part.x, max(planes.part.x, planes.part.y)).x;
}

fn hide_below_horizon(view: View) {
    let above = Planes(with_plane(vec2f(-1e9, 1e9), view, view.normal, -view.lift));
    for (var word = 0.0; word <= view.last_word; word += 1.0) {
        hide(word, ~bits_behind_planes(above, word));
    }
}

// From the receiver to the sample of a bit.
fn sample_at(view: View, word: f32, bit: u32) -> vec3f {
    let column = COLUMNS * word + f32(bit) + 0.5;
    return vec3f((column - view.first_column) / view.columns - view.origin.x, 0.0, view.height);
}

fn volume_of(view: View, corners: Corners) -> f32 {
    return dot(cross(corners.c - corners.a, corners.a - corners.b), corners.a);
}
