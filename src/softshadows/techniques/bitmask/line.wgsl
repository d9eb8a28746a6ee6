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
const LOWER_WORDS = vec4f(0.0, 1.0, 2.0, 3.0);
const UPPER_WORDS = vec4f(4.0, 5.0, 6.0, 7.0);

struct View {
    origin: vec3f,
    towards: vec2f,   // unit, in light space's y and z, from the receiver to the line
    normal: vec3f,
    height: f32,      // of the line above the receiver
    lift: f32,
    nearest: f32,
    t_max: f32,
    columns: f32,     // per metre
    first_column: f32,  // at the light's middle
};

fn turned(towards: vec2f, vector: vec3f) -> vec3f {
    return vec3f(vector.x, vector.y * towards.y - vector.z * towards.x, vector.y * towards.x + vector.z * towards.y);
}

fn view_of(receiver: LiftedReceiver, shift: vec2f) -> View {
    var view: View;
    let distance = max(length(receiver.origin.yz), CLOSE);
    view.origin = receiver.origin;
    view.towards = -receiver.origin.yz / distance;
    view.normal = turned(view.towards, receiver.normal);
    view.height = distance;
    view.lift = receiver.lift;
    view.nearest = PROJECTED * receiver.lift;
    view.t_max = 1.0 - receiver.light_lift / view.height;
    view.columns = 0.5 * COLUMNS * row_set.rows / light.half_width;
    view.first_column = 0.5 * COLUMNS * row_set.rows - COLUMNS * row_set.first_row - shift.x;
    return view;
}

fn corner_from(view: View, corner: vec3f) -> vec3f {
    return turned(view.towards, corner - view.origin);
}

fn column_at(view: View, x: vec3f) -> vec3f {
    return (x + view.origin.x) * view.columns + view.first_column;
}

// The bits of all words between two columns of the row.
fn lower_bits(left: f32, right: f32) -> vec4u {
    return bits_between(vec4f(left) - COLUMNS * LOWER_WORDS, vec4f(right) - COLUMNS * LOWER_WORDS);
}

fn upper_bits(left: f32, right: f32) -> vec4u {
    return bits_between(vec4f(left) - COLUMNS * UPPER_WORDS, vec4f(right) - COLUMNS * UPPER_WORDS);
}

fn marks_between(left: f32, right: f32) -> Marks {
    var marks: Marks;
    marks.lower = lower_bits(left, max(left, right));
    if has_upper_words {
        marks.upper = upper_bits(left, max(left, right));
    }
    return marks;
}

fn may_hide(view: View, low_ls: vec3f, high_ls: vec3f) -> bool {
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
    var open = lower_bits(left, right) & ~hidden_lower;
    if has_upper_words {
        open |= upper_bits(left, right) & ~hidden_upper;
    }
    return is_above && is_between && any(open != vec4u(0u));
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

fn marks_of_picture(view: View, a: vec3f, b: vec3f, c: vec3f) -> Marks {
    let scale = view.height / vec3f(a.z, b.z, c.z);
    let column = column_at(view, vec3f(a.x, b.x, c.x) * scale);
    let across = vec3f(a.y, b.y, c.y) * scale;
    var part = vec2f(1e9, -1e9);
    part = with_edge(part, vec2f(column.x, across.x), vec2f(column.y, across.y));
    part = with_edge(part, vec2f(column.y, across.y), vec2f(column.z, across.z));
    part = with_edge(part, vec2f(column.z, across.z), vec2f(column.x, across.x));
    return marks_between(part.x, part.y);
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

fn marks_of_planes(view: View, a: vec3f, b: vec3f, c: vec3f) -> Marks {
    let normal = cross(c - a, a - b);
    let volume = dot(normal, a);
    let side = select(-1.0, 1.0, volume >= 0.0);
    var part = vec2f(-1e9, 1e9);
    part = with_plane(part, view, side * edge_plane(c, b), 0.0);
    part = with_plane(part, view, side * edge_plane(a, c), 0.0);
    part = with_plane(part, view, side * edge_plane(b, a), 0.0);
    part = with_plane(part, view, side * normal * view.t_max, abs(volume));
    return marks_between(part.x, part.y);
}

fn hide_below_horizon(view: View) {
    let above = with_plane(vec2f(-1e9, 1e9), view, view.normal, -view.lift);
    hidden_lower |= ~lower_bits(above.x, max(above.x, above.y));
    if has_upper_words {
        hidden_upper |= ~upper_bits(above.x, max(above.x, above.y));
    }
}

// From the receiver to the sample of a bit.
fn sample_at(view: View, word: u32, bit: u32) -> vec3f {
    let column = COLUMNS * f32(word) + f32(bit) + 0.5;
    return vec3f((column - view.first_column) / view.columns - view.origin.x, 0.0, view.height);
}

fn volume_of(view: View, corners: Corners) -> f32 {
    return dot(cross(corners.c - corners.a, corners.a - corners.b), corners.a);
}
