// All samples of a rectangle light at once: which of them does a triangle hide from a receiver, and which could a box hide?
//
// Light space, seen from the receiver: x and y along the light, z towards it, `height` away. The light is cut into rows, each a
// line of 32 samples that climbs by SLANT of a row's height over the light's width, so that an edge along the light's sides
// does not meet all of a row at one place. A triangle covers one interval of a row. Rows and columns are measured in
// themselves: the sample in column c of row r is at (c + ½, r).
//
// A triangle between the receiver and the light is projected onto the light's plane and scanned row by row. One that reaches
// behind the receiver or past the light has no such picture: it is taken as the planes through the receiver and its edges,
// and its own plane.

//#include "receiver_view.wgsl"
//#include "hidden_samples.wgsl"
//#needs Corners

const EDGE_ROOM = 1e-3;  // columns and rows: more than float32 loses on the way of a box to the light's plane
const CLOSE = 1e-18;     // metres
const PROJECTED = 256.0;  // lifts before receiver and light from which on a triangle's picture is exact enough

// The receiver and the light that it sees.
struct View {
    origin: vec3f,        // the receiver, in light space, z before the light
    mirror: f32,          // of z: −1 where the receiver lies behind a two-sided light
    normal: vec3f,
    height: f32,          // of the light's plane above the receiver: positive
    lift: f32,            // metres that the origin is off the receiver's surface
    nearest: f32,         // metres before receiver and light, within which nothing is projected
    t_max: f32,           // share of the way to the light's plane beyond which nothing hides it
    columns: f32,         // per metre
    rows: f32,
    slant: f32,           // rows per column
    first_row: f32,       // where the row of number 0 would be at the light's left end, as a place in rows
    shift: f32,           // of the samples, in columns
};

fn view_of(receiver: LiftedReceiver, shift: vec2f) -> View {
    var view: View;
    view.mirror = select(1.0, -1.0, receiver.origin.z > 0.0);
    view.origin = vec3f(receiver.origin.xy, view.mirror * receiver.origin.z);
    view.normal = vec3f(receiver.normal.xy, view.mirror * receiver.normal.z);
    view.height = max(-view.origin.z, CLOSE);
    view.lift = receiver.lift;
    view.nearest = PROJECTED * receiver.lift;
    view.t_max = 1.0 - receiver.light_lift / view.height;
    view.columns = 0.5 * COLUMNS / light.half_width;
    view.rows = 0.5 * row_set.rows / light.half_height;
    view.slant = row_set.slant / COLUMNS;
    view.shift = shift.x;
    view.first_row = 0.5 * row_set.rows - 0.5 + 0.5 * row_set.slant - row_set.first_row - shift.y - view.slant * shift.x;
    return view;
}

fn corner_from(view: View, corner: vec3f) -> vec3f {
    return vec3f(corner.xy, view.mirror * corner.z) - view.origin;
}

fn column_at(view: View, x: f32) -> f32 {
    return x * view.columns + 0.5 * COLUMNS - view.shift;
}

// The number of the row that passes through a place of the light's plane; a fraction between rows.
fn row_at(view: View, y: f32, column: f32) -> f32 {
    return y * view.rows + view.first_row - view.slant * column;
}

fn rows_between(rows: vec4f, first: f32, last: f32) -> vec4u {
    return select(vec4u(0u), ALL, (rows >= vec4f(first)) & (rows <= vec4f(last)));
}

// Could the box, given by its corners in light space, hide a sample that is not hidden yet?
fn may_hide(view: View, low_ls: vec3f, high_ls: vec3f) -> bool {
    let one = corner_from(view, low_ls);
    let other = corner_from(view, high_ls);
    let low = min(one, other);
    let high = max(one, other);
    let middle = 0.5 * (low + high);
    let is_above = dot(view.normal, middle) + dot(abs(view.normal), high - middle) > 0.0;
    let is_between = high.z > 0.0 && low.z < view.height;
    // Its picture on the light's plane, widest where the box is nearest; what lies past the light hides nothing. A box that
    // reaches back to the receiver has a picture without end.
    let scale_near = view.height / max(low.z, CLOSE);
    let scale_far = max(view.height / max(high.z, CLOSE), 1.0);
    let left = min(low.x * scale_near, low.x * scale_far) + view.origin.x;
    let right = max(high.x * scale_near, high.x * scale_far) + view.origin.x;
    let bottom = min(low.y * scale_near, low.y * scale_far) + view.origin.y;
    let top = max(high.y * scale_near, high.y * scale_far) + view.origin.y;
    let first_column = clamp(column_at(view, left) - EDGE_ROOM, 0.0, COLUMNS);
    let last_column = clamp(column_at(view, right) + EDGE_ROOM, 0.0, COLUMNS);
    let first_row = row_at(view, bottom, last_column) - EDGE_ROOM;
    let last_row = row_at(view, top, first_column) + EDGE_ROOM;
    let columns = bits_between(vec4f(first_column), vec4f(last_column));
    var open = columns & ~hidden_lower & rows_between(LOWER_ROWS, first_row, last_row);
    if has_upper_words {
        open |= columns & ~hidden_upper & rows_between(UPPER_ROWS, first_row, last_row);
    }
    return is_above && is_between && any(open != vec4u(0u));
}

// The interval of a row between two corners of the picture: where the edge crosses it, if it does.
struct Crossings {
    left: vec4f,
    right: vec4f,
};

// An edge belongs to two triangles, and both must find the same crossing: it is measured from its lower end.
fn with_edge(crossings: Crossings, from_column: f32, from_row: f32, to_column: f32, to_row: f32, rows: vec4f) -> Crossings {
    let is_rising = from_row <= to_row;
    let low = select(vec2f(to_column, to_row), vec2f(from_column, from_row), is_rising);
    let high = select(vec2f(from_column, from_row), vec2f(to_column, to_row), is_rising);
    let step = (high.x - low.x) / (high.y - low.y);
    let place = low.x + (rows - low.y) * step;
    let is_crossed = (rows >= vec4f(low.y)) & (rows < vec4f(high.y));
    return Crossings(
        min(crossings.left, select(vec4f(1e9), place, is_crossed)),
        max(crossings.right, select(vec4f(-1e9), place, is_crossed)),
    );
}

fn bits_in_picture(column: vec3f, row: vec3f, rows: vec4f) -> vec4u {
    var crossings = Crossings(vec4f(1e9), vec4f(-1e9));
    crossings = with_edge(crossings, column.x, row.x, column.y, row.y, rows);
    crossings = with_edge(crossings, column.y, row.y, column.z, row.z, rows);
    crossings = with_edge(crossings, column.z, row.z, column.x, row.x, rows);
    return bits_between(crossings.left, crossings.right);
}

fn marks_of_picture(view: View, a: vec3f, b: vec3f, c: vec3f) -> Marks {
    var marks: Marks;
    let scale = view.height / vec3f(a.z, b.z, c.z);
    let x = vec3f(a.x, b.x, c.x) * scale + view.origin.x;
    let y = vec3f(a.y, b.y, c.y) * scale + view.origin.y;
    let column = x * view.columns + (0.5 * COLUMNS - view.shift);
    let row = y * view.rows + view.first_row - view.slant * column;
    let first_row = min(row.x, min(row.y, row.z));
    let last_row = max(row.x, max(row.y, row.z));
    let is_beside = min(column.x, min(column.y, column.z)) > COLUMNS - 0.5 || max(column.x, max(column.y, column.z)) < 0.5;
    if is_beside || max(ceil(first_row), 0.0) > min(floor(last_row), row_set.count - 1.0) {
        return marks;
    }
    marks.lower = bits_in_picture(column, row, LOWER_ROWS);
    if has_upper_words {
        marks.upper = bits_in_picture(column, row, UPPER_ROWS);
    }
    return marks;
}

// Twice the plane through the receiver and an edge: exactly the negative for the edge's other direction, even where products
// and sums are fused (Woop et al. 2013).
fn edge_plane(start: vec3f, end: vec3f) -> vec3f {
    return cross(end + start, start - end);
}

// A plane's value at a row's samples is linear in the column. Samples lie on the hidden side between these columns.
fn with_plane(crossings: Crossings, view: View, plane: vec3f, offset: f32, rows: vec4f) -> Crossings {
    let per_column = vec3f(1.0 / view.columns, view.slant / view.rows, 0.0);
    let left_end = vec3f(
        (view.shift - 0.5 * COLUMNS) / view.columns - view.origin.x,
        -view.first_row / view.rows - view.origin.y,
        view.height,
    );
    let slope = dot(plane, per_column);
    let safe_slope = select(slope, 1e-30, slope == 0.0);
    let at_start = dot(plane, left_end) - offset + plane.y * rows / view.rows;
    let place = -at_start / safe_slope;
    let is_rising = safe_slope > 0.0;
    return Crossings(
        max(crossings.left, select(vec4f(-1e9), place, is_rising)),
        min(crossings.right, select(place, vec4f(1e9), is_rising)),
    );
}

struct Planes {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    own: vec3f,
    offset: f32,
};

fn bits_behind_planes(view: View, planes: Planes, rows: vec4f) -> vec4u {
    var crossings = Crossings(vec4f(-1e9), vec4f(1e9));
    crossings = with_plane(crossings, view, planes.a, 0.0, rows);
    crossings = with_plane(crossings, view, planes.b, 0.0, rows);
    crossings = with_plane(crossings, view, planes.c, 0.0, rows);
    crossings = with_plane(crossings, view, planes.own, planes.offset, rows);
    return bits_between(crossings.left, max(crossings.left, crossings.right));
}

fn marks_of_planes(view: View, a: vec3f, b: vec3f, c: vec3f) -> Marks {
    let normal = cross(c - a, a - b);
    let volume = dot(normal, a);
    let side = select(-1.0, 1.0, volume >= 0.0);
    let plane_a = side * edge_plane(c, b);
    let plane_b = side * edge_plane(a, c);
    let plane_c = side * edge_plane(b, a);
    let planes = Planes(plane_a, plane_b, plane_c, side * normal * view.t_max, abs(volume));
    var marks: Marks;
    marks.lower = bits_behind_planes(view, planes, LOWER_ROWS);
    if has_upper_words {
        marks.upper = bits_behind_planes(view, planes, UPPER_ROWS);
    }
    return marks;
}

// From the receiver to the sample of a bit.
fn sample_at(view: View, word: u32, bit: u32) -> vec3f {
    let column = f32(bit) + 0.5;
    let x = (column - 0.5 * COLUMNS + view.shift) / view.columns;
    let y = (f32(word) - view.first_row + view.slant * column) / view.rows;
    return vec3f(x, y, 0.0) - vec3f(view.origin.xy, -view.height);
}

// Samples below the receiver's horizon are hidden.
fn bits_below_horizon(view: View, rows: vec4f) -> vec4u {
    let above = with_plane(Crossings(vec4f(-1e9), vec4f(1e9)), view, view.normal, -view.lift, rows);
    return ~bits_between(above.left, max(above.left, above.right));
}

fn hide_below_horizon(view: View) {
    hidden_lower |= bits_below_horizon(view, LOWER_ROWS);
    if has_upper_words {
        hidden_upper |= bits_below_horizon(view, UPPER_ROWS);
    }
}

// How the corners run as the receiver sees them: positive where it sees the triangle's back.
fn volume_of(view: View, corners: Corners) -> f32 {
    return view.mirror * dot(cross(corners.c - corners.a, corners.a - corners.b), corners.a);
}
