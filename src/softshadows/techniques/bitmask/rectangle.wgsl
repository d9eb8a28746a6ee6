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
    place: vec3f,         // the same in the tree's space
    mirror: f32,          // of z: −1 where the receiver lies behind a two-sided light
    normal: vec3f,
    height: f32,          // of the light's plane above the receiver: positive
    lift: f32,            // metres that the origin is off the receiver's surface
    nearest: f32,         // metres before receiver and light, within which nothing is projected
    t_max: f32,           // share of the way to the light's plane beyond which nothing hides it
    columns: f32,         // per metre
    rows: f32,
    slant: f32,           // rows per column
    middle: vec2f,        // column and, at column 0, row of the light's middle
    last_word: f32,       // of this walk
    solid_count: u32,     // triangles of solids, of which the far side alone marks
    opaque_count: u32,    // triangles before those with an alpha mask
    grid: Grid,
};

// The grid of the tree's boxes, seen from the receiver: x in columns, y in rows, z as a share of the way to the light's plane.
struct Grid {
    low: vec3f,
    cell: vec3f,
    normal: vec3f,        // of the receiver's surface, to be multiplied with such places
    rises: vec3<bool>,    // towards a box's high corner, above that surface
    end: vec2f,           // column and row of the place below the receiver, where x and y are 0
};

fn view_of(receiver: LiftedReceiver, shift: vec2f) -> View {
    var view: View;
    view.mirror = select(1.0, -1.0, receiver.origin.z > 0.0);
    view.origin = vec3f(receiver.origin.xy, view.mirror * receiver.origin.z);
    view.place = receiver.place;
    view.normal = vec3f(receiver.normal.xy, view.mirror * receiver.normal.z);
    view.height = max(-view.origin.z, CLOSE);
    view.lift = receiver.lift;
    view.nearest = PROJECTED * receiver.lift;
    view.t_max = 1.0 - receiver.light_lift / view.height;
    view.columns = 0.5 * COLUMNS / light.half_width;
    view.rows = 0.5 * row_set.rows / light.half_height;
    view.slant = row_set.slant / COLUMNS;
    view.middle = vec2f(0.5 * COLUMNS - shift.x, 0.5 * row_set.rows - 0.5 + 0.5 * row_set.slant - row_set.first_row - shift.y);
    view.middle.y -= view.slant * shift.x;
    view.last_word = row_set.count - 1.0;
    view.solid_count = light_tree.solid_count;
    view.opaque_count = light_tree.opaque_count;

    let units = vec3f(view.columns, view.rows, view.mirror / view.height);
    view.grid.low = (light_tree.low_ws - receiver.place) * units;
    view.grid.cell = units / light_tree.cells_per_metre;
    view.grid.normal = receiver.normal / units;
    view.grid.rises = view.grid.normal * view.grid.cell > vec3f(0.0);
    view.grid.end = view.middle + view.origin.xy * units.xy;
    return view;
}

fn corner_from(view: View, corner: vec3f) -> vec3f {
    let from_receiver = corner - view.place;
    return vec3f(from_receiver.xy, view.mirror * from_receiver.z);
}

// Could a box hide a sample that is not hidden yet?
fn may_hide(view: View, box: vec4u) -> bool {
    let one = view.grid.low + box_low(box) * view.grid.cell;
    let other = view.grid.low + box_high(box) * view.grid.cell;
    let is_above = dot(view.grid.normal, select(one, other, view.grid.rises)) > 0.0;
    let near = select(one.z, other.z, view.mirror < 0.0);
    let far = select(other.z, one.z, view.mirror < 0.0);
    let is_between = far > 0.0 && near < 1.0;
    // Its picture on the light's plane, widest where the box is nearest; what lies past the light hides nothing. A box that
    // reaches back to the receiver has a picture without end.
    let scale_near = 1.0 / max(near, CLOSE);
    let scale_far = max(1.0 / max(far, CLOSE), 1.0);
    let low = one.xy * select(vec2f(scale_far), vec2f(scale_near), one.xy < vec2f(0.0)) + (view.grid.end - EDGE_ROOM);
    let high = other.xy * select(vec2f(scale_far), vec2f(scale_near), other.xy > vec2f(0.0)) + (view.grid.end + EDGE_ROOM);
    let left = clamp(low.x, 0.0, COLUMNS);
    let right = clamp(high.x, 0.0, COLUMNS);
    let bottom = low.y - view.slant * right;
    let top = high.y - view.slant * left;
    let bits = bits_between(vec4f(left), vec4f(right));
    var open = bits & ~hidden_lower & words_between(LOWER_WORDS, bottom, top);
    if has_upper_words {
        open |= bits & ~hidden_upper & words_between(UPPER_WORDS, bottom, top);
    }
    return is_above && is_between && any(open != NONE);
}

fn words_between(words: vec4f, first: f32, last: f32) -> vec4u {
    return select(NONE, ALL, (words >= vec4f(first)) & (words <= vec4f(last)));
}

// A triangle's picture on the light's plane, in columns and rows, and the rows that it touches.
struct Picture {
    a: vec2f,
    b: vec2f,
    c: vec2f,
    first: f32,
    last: f32,
};

fn picture_of(view: View, corners: Corners) -> Picture {
    let scale = view.height / vec3f(corners.a.z, corners.b.z, corners.c.z);
    let x = vec3f(corners.a.x, corners.b.x, corners.c.x) * scale + view.origin.x;
    let y = vec3f(corners.a.y, corners.b.y, corners.c.y) * scale + view.origin.y;
    let column = x * view.columns + view.middle.x;
    let row = y * view.rows + view.middle.y - view.slant * column;
    let lowest = min(row.x, min(row.y, row.z));
    let highest = max(row.x, max(row.y, row.z));
    let is_beside = min(column.x, min(column.y, column.z)) > COLUMNS - 0.5 || max(column.x, max(column.y, column.z)) < 0.5;
    let last = select(min(floor(highest), view.last_word), -1.0, is_beside);
    return Picture(vec2f(column.x, row.x), vec2f(column.y, row.y), vec2f(column.z, row.z), max(ceil(lowest), 0.0), last);
}

// The interval of a row between two corners of the picture: where the edge crosses it, if it does. An edge belongs to two
// triangles, and both must find the same crossing: it is measured from its lower end.
fn with_edge(interval: vec2f, from_corner: vec2f, to_corner: vec2f, row: f32) -> vec2f {
    let is_rising = from_corner.y <= to_corner.y;
    let low = select(to_corner, from_corner, is_rising);
    let high = select(from_corner, to_corner, is_rising);
    let step = (high.x - low.x) / (high.y - low.y);
    let place = low.x + (row - low.y) * step;
    let is_crossed = row >= low.y && row < high.y;
    return vec2f(
        select(interval.x, place, is_crossed && place < interval.x),
        select(interval.y, place, is_crossed && place > interval.y),
    );
}

fn bits_in_picture(view: View, picture: Picture, row: f32) -> u32 {
    var interval = vec2f(1e9, -1e9);
    interval = with_edge(interval, picture.a, picture.b, row);
    interval = with_edge(interval, picture.b, picture.c, row);
    interval = with_edge(interval, picture.c, picture.a, row);
    return word_between(interval.x, interval.y);
}

// Twice the plane through the receiver and an edge: exactly the negative for the edge's other direction, even where products
// and sums are fused (Woop et al. 2013).
fn edge_plane(start: vec3f, end: vec3f) -> vec3f {
    return cross(end + start, start - end);
}

// Planes that bound what a triangle hides, the three of its edges and its own: where each crosses the line of row 0, by how
// much that moves from row to row, and whether samples are hidden to the right of it.
struct Planes {
    place: vec4f,
    step: vec4f,
    is_rising: vec4<bool>,
};

fn planes_of(view: View, corners: Corners) -> Planes {
    let normal = cross(corners.c - corners.a, corners.a - corners.b);
    let volume = dot(normal, corners.a);
    let side = select(-1.0, 1.0, volume >= 0.0);
    return bounding(
        view,
        side * edge_plane(corners.c, corners.b),
        side * edge_plane(corners.a, corners.c),
        side * edge_plane(corners.b, corners.a),
        side * normal * view.t_max,
        vec4f(0.0, 0.0, 0.0, abs(volume)),
    );
}

// The planes with these normals, and offsets from the receiver.
fn bounding(view: View, a: vec3f, b: vec3f, c: vec3f, own: vec3f, offsets: vec4f) -> Planes {
    let per_column = vec3f(1.0 / view.columns, view.slant / view.rows, 0.0);
    let start = vec3f(-view.middle.x / view.columns, -view.middle.y / view.rows, 0.0) - vec3f(view.origin.xy, -view.height);
    let slope = vec4f(dot(a, per_column), dot(b, per_column), dot(c, per_column), dot(own, per_column));
    let safe_slope = select(slope, vec4f(1e-30), slope == vec4f(0.0));
    let at_start = vec4f(dot(a, start), dot(b, start), dot(c, start), dot(own, start)) - offsets;
    let per_row = vec4f(a.y, b.y, c.y, own.y) / view.rows;
    return Planes(-at_start / safe_slope, -per_row / safe_slope, safe_slope > vec4f(0.0));
}

fn bits_behind_planes(planes: Planes, row: f32) -> u32 {
    let place = planes.place + row * planes.step;
    let left = select(vec4f(-1e9), place, planes.is_rising);
    let right = select(place, vec4f(1e9), planes.is_rising);
    let last_left = max(max(left.x, left.y), max(left.z, left.w));
    return word_between(last_left, max(last_left, min(min(right.x, right.y), min(right.z, right.w))));
}

// From the receiver to the sample of a bit.
fn sample_at(view: View, row: f32, bit: u32) -> vec3f {
    let column = f32(bit) + 0.5;
    let x = (column - view.middle.x) / view.columns;
    let y = (row - view.middle.y + view.slant * column) / view.rows;
    return vec3f(x, y, 0.0) - vec3f(view.origin.xy, -view.height);
}

// Samples below the receiver's horizon are hidden.
fn hide_below_horizon(view: View) {
    let above = bounding(view, view.normal, view.normal, view.normal, view.normal, vec4f(-view.lift));
    for (var row = 0.0; row <= view.last_word; row += 1.0) {
        hide(row, ~bits_behind_planes(above, row));
    }
}

// How the corners run as the receiver sees them: positive where it sees the triangle's back.
fn volume_of(view: View, corners: Corners) -> f32 {
    return view.mirror * dot(cross(corners.c - corners.a, corners.a - corners.b), corners.a);
}
