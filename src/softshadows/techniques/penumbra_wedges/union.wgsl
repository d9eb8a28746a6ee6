// Occluders by soft shadow volumes: for each of 256 points of the light, how many layers hide it from the receiver. Exact for any
// number of overlapping occluders, and for silhouettes that no one point of the light sees whole.
// [Laine2005 §3] Laine, Aila, Assarsson, Lehtinen, Akenine-Möller, "Soft Shadow Volumes for Ray Tracing", SIGGRAPH 2005
//
// The layers at the light's centre are counted in layers.wgsl. From there a path leads to every point, up or down the centre's
// column to its row and then along the row, and the count changes wherever the path crosses an edge that is a silhouette for this
// receiver. Counts of all points change at once: bit b of all 256 counts is kept together, a row of points in 16 bits.

//#include "layers.wgsl"
//#include "coverage.wgsl"
//#include "horizon.wgsl"

@group(1) @binding(6) var<storage, read> edge_records: array<vec4u>;  // ends, triangle sides (silhouettes.wgsl)

const EDGE_ROUNDS = 18u;        // of loops that an edge may take: its own, one for each row of points, and one to leave them

const ROWS = 16u;
const ROW_BITS = 0xffffu;
const WORDS = 8u;
const COUNT_BITS = 6u;          // layers are counted modulo 64
const CENTER = 7.5;             // the light's centre, as column and as row
const NEAR = 1e-6;              // an edge is cut this close to the receiver's height, as a share of its farther end's distance from it

// What a receiver keeps between dispatches.
const STATE_BYTES = 288u;
struct UnionState {
    walk: vec4u,
    counts: array<u32, 48>,
    steps: array<i32, 16>,
    layers: vec2u,
};

@group(1) @binding(5) var<storage, read_write> states: array<UnionState>;

var<private> counts: array<u32, 48>;   // [bit][word]
var<private> layers: vec2u;            // between the receiver and the light's centre
var<private> steps: array<i32, 16>;    // by row: layers more than in the row before it, on the way from the centre

fn restore_state(slot: u32) {
    counts = states[slot].counts;
    steps = states[slot].steps;
    layers = states[slot].layers;
}

fn keep_state(slot: u32, walk: vec4u) {
    states[slot] = UnionState(walk, counts, steps, layers);
}

// The points: row j, column i lies at (16 i + j, 16 j + i) / 128 - 255 / 256 of the light. All 256 have their own x and their own
// y, so that an edge along the light's side passes them one by one; yet each row is a straight line.
// From homogeneous light units to homogeneous columns and rows.
fn to_lattice(q: vec3f) -> vec3f {
    let x = 128.0 * q.x + 127.5 * q.z;
    let y = 128.0 * q.y + 127.5 * q.z;
    return vec3f((16.0 * x - y) / 255.0, (16.0 * y - x) / 255.0, q.z);
}

// Add 1, or take 1 away, in bit `b` of the counts of the points in `carry`; what carries over is returned.
fn add_bit(b: u32, word: u32, carry: u32, is_more: bool) -> u32 {
    let before = counts[b * WORDS + word];
    counts[b * WORDS + word] = before ^ carry;
    return carry & select(~before, before, is_more);
}

// Add the power of two that bit `b` stands for. Written out, since a loop's rounds are counted (gpu/driver.wgsl).
fn add_power(b: u32, word: u32, bits: u32, is_more: bool) {
    var carry = bits;
    if b == 0u {
        carry = add_bit(0u, word, carry, is_more);
    }
    if b <= 1u {
        carry = add_bit(1u, word, carry, is_more);
    }
    if b <= 2u {
        carry = add_bit(2u, word, carry, is_more);
    }
    if b <= 3u {
        carry = add_bit(3u, word, carry, is_more);
    }
    if b <= 4u {
        carry = add_bit(4u, word, carry, is_more);
    }
    carry = add_bit(5u, word, carry, is_more);
}

// Add `change` to the counts of the points in `bits` of a word.
fn add_to_word(word: u32, bits: u32, change: i32) {
    for (var b = 0u; b < COUNT_BITS; b++) {
        if ((u32(abs(change)) >> b) & 1u) == 1u {
            add_power(b, word, bits, change > 0);
        }
    }
}

fn add_to_row(row: u32, bits: u32, change: i32) {
    add_to_word(row / 2u, bits << (16u * (row & 1u)), change);
}

// The column is crossed between two rows, upward by `change` more layers: the rows beyond, as seen from the centre, have as many
// more. `next` is the row above the crossing.
fn cross_column(next: u32, is_upper: bool, change: i32) {
    if is_upper && next < ROWS {
        steps[next] += change;
    } else if !is_upper && next > 0u {
        steps[next - 1u] -= change;
    }
}

// The row of points that an edge, walked upward from `start`, comes to first.
fn first_row_above(start: vec3f) -> u32 {
    let row = u32(clamp(ceil(start.y / start.z), 0.0, 16.0));
    if row > 0u && start.y <= f32(row - 1u) * start.z {
        return row - 1u;
    }
    if row < ROWS && start.y > f32(row) * start.z {
        return row + 1u;
    }
    return row;
}

// An edge that has more layers on its left than on its right: 1 or 2 of them, or as many fewer. All that is asked of its place
// relative to the points is asked once, for each row, so that its crossings fit together whatever rounding does.
fn add_silhouette(a: vec3f, b: vec3f, counter_clockwise: bool, left_minus_right: i32) {
    let least = NEAR * max(abs(a.z), abs(b.z));
    if max(a.z, b.z) <= least {
        return;
    }
    var start = a;
    var end = b;
    if start.z < least {
        start = vec3f(mix(a, b, (least - a.z) / (b.z - a.z)).xy, least);
    } else if end.z < least {
        end = vec3f(mix(b, a, (least - b.z) / (a.z - b.z)).xy, least);
    }
    var weight = left_minus_right;
    var center_is_left = counter_clockwise;
    if start.y * end.z > end.y * start.z {  // walk upward
        let other = start;
        start = end;
        end = other;
        weight = -weight;
        center_is_left = !center_is_left;
    }

    var is_right = start.x >= CENTER * start.z;
    var is_upper = start.y > CENTER * start.z;
    var row = first_row_above(start);
    loop {
        if !is_upper && row == 8u {
            if end.y <= CENTER * end.z {
                break;
            }
            // Past the centre.
            if is_right == center_is_left {
                is_upper = true;
            } else {
                cross_column(row, is_upper, select(weight, -weight, is_right));
                is_right = center_is_left;
                is_upper = true;
            }
        }
        if row >= ROWS || end.y <= f32(row) * end.z {
            break;
        }
        let below = start.y - f32(row) * start.z;
        let above = end.y - f32(row) * end.z;
        let at = mix(start, end, below / (below - above));
        let column = at.x / at.z;
        if (column > CENTER) != is_right {
            cross_column(row, is_upper, select(weight, -weight, is_right));
            is_right = !is_right;
        }
        let first = u32(clamp(ceil(column), 0.0, 16.0));  // of the points to the right
        let bits = select((1u << first) - 1u, (ROW_BITS << first) & ROW_BITS, is_right);
        add_power(u32(abs(weight)) - 1u, row / 2u, bits << (16u * (row & 1u)), (weight > 0) != is_right);
        row += 1u;
    }
    if (end.x >= CENTER * end.z) != is_right {
        cross_column(row, is_upper, select(weight, -weight, is_right));
    }
}

// -- One receiver's silhouettes ---------------------------------------------------------------------------------------

var<workgroup> shared_sides: array<vec2u, LANES>;
var<workgroup> shared_side_planes: array<vec4f, 128>;

fn load_edge(lane: u32, cluster: WedgeCluster, shaft: Shaft) -> bool {
    if lane >= cluster.count {
        return false;
    }
    let edge = edges[cluster.first + lane];
    if edge.is_silhouette == 0u || !segment_in_shaft(shaft, edge.a, edge.b) {
        return false;
    }
    let sides = edge_records[cluster.first + lane].zw;
    shared_edges[lane] = edge;
    shared_sides[lane] = sides;
    shared_side_planes[2u * lane] = planes[max(sides.x >> 1u, 1u) - 1u];
    shared_side_planes[2u * lane + 1u] = planes[max(sides.y >> 1u, 1u) - 1u];
    return true;
}

// +1 where the triangle lies on the edge's left as the receiver sees them, -1 on its right, 0 without a triangle.
fn side_seen(side: u32, plane: vec4f, receiver: vec3f) -> i32 {
    if side == 0u {
        return 0;
    }
    return select(1, -1, is_before(plane, receiver) != ((side & 1u) == 1u));
}

fn add_shared_edge(index: u32, receiver: vec3f) {
    let sides = shared_sides[index];
    let left_minus_right = side_seen(sides.x, shared_side_planes[2u * index], receiver)
        + side_seen(sides.y, shared_side_planes[2u * index + 1u], receiver);
    if left_minus_right == 0 {
        return;
    }
    let edge = shared_edges[index];
    let q0 = on_light(receiver, edge.a);
    let q1 = on_light(receiver, edge.b);
    if misses_light(q0, q1) || max(q0.z, q1.z) <= 0.0 {
        return;
    }
    add_silhouette(to_lattice(q0), to_lattice(q1), !side_of_center(edge.normal, receiver), left_minus_right);
}

fn add_occluders(lane: u32, receiver: WedgeReceiver, walk: ptr<function, Walk>) {
    layers += layers_in(lane, receiver, side.edge_cluster_count, side.triangle_cluster_count, walk);
    if !(*walk).is_paused && !is_point(side.light) {
        add_edges(lane, receiver, 0u, side.edge_cluster_count, walk);
    }
}

// Give every row what the column has crossed on the way to it.
fn add_steps() {
    var above = 0;
    var below = 0;
    for (var k = 0u; k < ROWS / 2u; k++) {
        above += steps[ROWS / 2u + k];
        below += steps[ROWS / 2u - 1u - k];
        add_to_row(ROWS / 2u + k, ROW_BITS, above);
        add_to_row(ROWS / 2u - 1u - k, ROW_BITS, below);
    }
}

// The points of a row that lie above the receiver's horizon.
fn above_horizon(receiver: WedgeReceiver, row: u32) -> u32 {
    let height = horizon(receiver);
    let j = f32(row);
    let at = vec2f(2.0 * j + 1.0, 32.0 * j + 1.0) / 256.0 - 1.0;  // of column 0
    let first = height.x + dot(height.yz, at);
    let rise = dot(height.yz, vec2f(32.0, 2.0)) / 256.0;
    var bits = 0u;
    for (var i = 0u; i < 16u; i++) {
        bits |= select(0u, 1u << i, first + rise * f32(i) > 0.0);
    }
    return bits;
}

fn visible_share(receiver: WedgeReceiver) -> f32 {
    if is_point(side.light) {
        return select(share_above_horizon(receiver), 0.0, any(layers > vec2u(0u)));
    }
    for (var word = 0u; word < WORDS; word++) {
        add_to_word(word, 0xffffffffu, i32(layers.x + layers.y));
    }
    add_steps();
    let all_above = share_above_horizon(receiver) == 1.0;
    var visible = 0u;
    for (var word = 0u; word < WORDS; word++) {
        var hidden = 0u;
        for (var b = 0u; b < COUNT_BITS; b++) {
            hidden |= counts[b * WORDS + word];
        }
        var above = 0xffffffffu;
        if !all_above {
            above = above_horizon(receiver, 2u * word) | (above_horizon(receiver, 2u * word + 1u) << 16u);
        }
        visible += countOneBits(above & ~hidden);
    }
    return f32(visible) / 256.0;
}
