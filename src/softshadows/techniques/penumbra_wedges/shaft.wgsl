// A tile of 8×8 receivers at work: one lane per receiver, and all of them together look for what may hide the light from any.
//
// The tile's shaft (Haines and Wallace 1991) is bounded by a plane through each side of the light, as steep as the steepest
// pyramid from a receiver to the light, and by the lowest receiver. What lies outside it is dropped, first whole clusters,
// then what they hold. It replaces the paper's rasterised wedges: a receiver outside a wedge finds that its edge misses the
// light. [Forest2006 §4.2] "a quick test to know whether a fragment is outside the half-wedge"

//#include "passes/gbuffer/receiver.wgsl"

@group(1) @binding(0) var<storage, read> edges: array<WedgeEdge>;
@group(1) @binding(1) var<storage, read> clusters: array<WedgeCluster>;  // of edges, then of triangles
@group(1) @binding(2) var<storage, read> planes: array<vec4f>;
@group(1) @binding(3) var<storage, read> triangle_records: array<vec4u>;
@group(1) @binding(4) var<storage, read_write> visibility: array<f32>;
@group(2) @binding(0) var<storage, read> light: WedgeLight;
@group(3) @binding(0) var<uniform> first_tile_row: vec4u;  // of the band of the image that this dispatch does, in x

//#include "light_frame.wgsl"

const LANES = 64u;
const STEEPEST = 1e30;   // slope of a pyramid to a receiver in the light's plane
const SLACK = 1e-5;      // relative: what just touches the shaft is kept

struct Shaft {
    slopes: vec4f,   // growth of the half extents to +x, -x, +y, -y per metre of depth
    half: f32,       // extent at the light: 1, or 0 for the shaft to its centre
    depth: f32,      // of the lowest receiver
};

struct WedgeReceiver {
    exists: bool,         // lies in the image
    is_surface: bool,
    is_lightable: bool,   // shows a surface, and lies before the light
    pixel: u32,           // of this light's visibility
    point: vec3f,         // in light units
    normal: vec3f,        // its product with a vector in light units is that in metres
};

var<workgroup> steepest_to_border: array<vec4f, LANES>;
var<workgroup> steepest_to_center: array<vec4f, LANES>;
var<workgroup> deepest: array<f32, LANES>;
var<workgroup> ballot: array<atomic<u32>, 2>;
var<workgroup> ballot_result: vec2u;
var<workgroup> shared_normals: array<vec4f, 192>;
var<workgroup> shared_planes: array<vec4f, LANES>;
var<workgroup> shared_edges: array<WedgeEdge, LANES>;

fn wedge_receiver(group: vec2u, local: vec2u) -> WedgeReceiver {
    let pixel = (group + vec2u(0u, first_tile_row.x)) * 8u + local;
    var receiver: WedgeReceiver;
    if any(pixel >= frame.size) {
        return receiver;
    }
    let surface = load_receiver(pixel);
    receiver.exists = true;
    receiver.is_surface = surface.is_surface;
    receiver.pixel = light.visibility_offset + pixel.y * frame.size.x + pixel.x;
    // Free of its own surface by more than rounding can take back.
    receiver.point = to_light_units(surface.position_ws + surface.normal_ws * light.receiver_offset - light.center_ws);
    receiver.normal = normal_in_light_units(surface.normal_ws);
    receiver.is_lightable = surface.is_surface && receiver.point.z < 0.0;
    return receiver;
}

// The shafts to the light and to its centre, around the lightable receivers of all lanes. The second's depth is the first's.
fn gather_shafts(lane: u32, receiver: WedgeReceiver) {
    let p = receiver.point;
    let depth = max(-p.z, 1e-30);
    let none = vec4f(-STEEPEST);
    let to_border = clamp((vec4f(p.x, -p.x, p.y, -p.y) - 1.0) / depth, none, -none);
    let to_center = clamp(vec4f(p.x, -p.x, p.y, -p.y) / depth, none, -none);
    steepest_to_border[lane] = select(none, to_border, receiver.is_lightable);
    steepest_to_center[lane] = select(none, to_center, receiver.is_lightable);
    deepest[lane] = select(-1.0, depth, receiver.is_lightable);
    for (var step = LANES / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if lane < step {
            steepest_to_border[lane] = max(steepest_to_border[lane], steepest_to_border[lane + step]);
            steepest_to_center[lane] = max(steepest_to_center[lane], steepest_to_center[lane + step]);
            deepest[lane] = max(deepest[lane], deepest[lane + step]);
        }
    }
    workgroupBarrier();
}

fn shaft_to_light() -> Shaft {
    return Shaft(steepest_to_border[0], 1.0, deepest[0]);
}

fn shaft_to_center() -> Shaft {
    return Shaft(steepest_to_center[0], 0.0, deepest[0]);
}

// How far a point lies beyond each side of the shaft; what is between the sides is negative.
fn beyond_sides(shaft: Shaft, point: vec3f) -> vec4f {
    let across = vec4f(point.x, -point.x, point.y, -point.y);
    let reach = shaft.half - shaft.slopes * point.z;
    return across - reach - SLACK * (abs(across) + shaft.half + abs(shaft.slopes * point.z));
}

fn box_in_shaft(shaft: Shaft, low: vec3f, high: vec3f) -> bool {
    let nearest = vec4f(low.x, -high.x, low.y, -high.y);
    let z = select(vec4f(high.z), vec4f(low.z), shaft.slopes > vec4f(0.0));  // where the shaft is widest
    let reach = shaft.half - shaft.slopes * z;
    let slack = SLACK * (abs(nearest) + shaft.half + abs(shaft.slopes * z));
    return low.x <= high.x && all(nearest - reach <= slack) && low.z < 0.0 && -high.z <= shaft.depth * (1.0 + SLACK);
}

fn segment_in_shaft(shaft: Shaft, a: vec3f, b: vec3f) -> bool {
    return all(min(beyond_sides(shaft, a), beyond_sides(shaft, b)) <= vec4f(0.0))
        && min(-a.z, -b.z) <= shaft.depth * (1.0 + SLACK);
}

// What all lanes vote, as bits. A lane without a question votes no.
fn votes(lane: u32, vote: bool) -> vec2u {
    if lane < 2u {
        atomicStore(&ballot[lane], 0u);
    }
    workgroupBarrier();
    if vote {
        atomicOr(&ballot[lane / 32u], 1u << (lane % 32u));
    }
    workgroupBarrier();
    if lane == 0u {
        ballot_result = vec2u(atomicLoad(&ballot[0]), atomicLoad(&ballot[1]));
    }
    return workgroupUniformLoad(&ballot_result);
}

// The lowest bit of a ballot, and the ballot without it.
fn first_vote(bits: vec2u) -> u32 {
    return select(32u + firstTrailingBit(bits.y), firstTrailingBit(bits.x), bits.x != 0u);
}

fn without_first_vote(bits: vec2u) -> vec2u {
    return select(vec2u(0u, bits.y & (bits.y - 1u)), vec2u(bits.x & (bits.x - 1u), bits.y), bits.x != 0u);
}

fn vote_count(bits: vec2u) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// -- A dispatch's share of the work -------------------------------------------------------------------------------------
// llvmpipe ends an invocation after 65535 rounds of all its loops, and watchdogs end a dispatch that takes seconds. So a tile pauses
// before it has taken its share, keeps what its receivers know, and the next dispatch goes on from there (dispatches.py).

override is_in_parts: bool = false;  // may one dispatch not be enough?
override rounds_of_dispatch: u32 = 50000;

struct Walk {
    object: u32,            // that the tile is at
    triangle_cluster: u32,  // the object's next ones
    edge_cluster: u32,
    is_done: bool,
    is_paused: bool,
    rounds: u32,            // of its loops that this dispatch may still take
};

var<workgroup> kept_walk: vec4u;

// Where the tile goes on. What is kept is the same for all its receivers, and zeros at first.
fn begin_walk(lane: u32, kept: vec4u) -> Walk {
    if lane == 0u {
        kept_walk = kept;
    }
    let shared_walk = workgroupUniformLoad(&kept_walk);
    return Walk(shared_walk.x, shared_walk.y, shared_walk.z, shared_walk.w == 1u, false, rounds_of_dispatch);
}

fn kept_of(walk: Walk) -> vec4u {
    return vec4u(walk.object, walk.triangle_cluster, walk.edge_cluster, u32(!walk.is_paused));
}

// Place of a receiver's state among those of the band.
fn state_index(group: vec2u, lane: u32) -> u32 {
    let columns = (frame.size.x + 7u) / 8u;
    return (group.y * columns + group.x) * LANES + lane;
}

// Pause the walk where `most` further rounds may be too many.
fn must_pause(walk: ptr<function, Walk>, most: u32) -> bool {
    (*walk).is_paused = (*walk).rounds < most;
    return (*walk).is_paused;
}

fn spend(walk: ptr<function, Walk>, rounds: u32) {
    (*walk).rounds -= min((*walk).rounds, rounds);
}

// -- Layers: how many triangles lie between the receiver and the light's centre ---------------------------------------
// The paper draws shadow volumes for it; the result is that of z-fail with an infinite far plane, wherever the camera is.
// [Forest2006 §4.1]

// Bring a triangle of a cluster into shared memory. Is it in the shaft to the light's centre?
fn load_triangle(lane: u32, cluster: WedgeCluster, shaft: Shaft) -> bool {
    if lane >= cluster.count {
        return false;
    }
    let record = triangle_records[cluster.first + lane];
    let e0 = edges[record.x >> 1u];
    let e1 = edges[record.y >> 1u];
    let e2 = edges[record.z >> 1u];
    shared_normals[3u * lane] = vec4f(e0.normal, f32(record.x & 1u));
    shared_normals[3u * lane + 1u] = vec4f(e1.normal, f32(record.y & 1u));
    shared_normals[3u * lane + 2u] = vec4f(e2.normal, f32(record.z & 1u));
    shared_planes[lane] = planes[record.w];
    var nearest = min(beyond_sides(shaft, e0.a), beyond_sides(shaft, e0.b));
    nearest = min(nearest, min(beyond_sides(shaft, e1.a), beyond_sides(shaft, e1.b)));
    nearest = min(nearest, min(beyond_sides(shaft, e2.a), beyond_sides(shaft, e2.b)));  // ends differ where the light cuts them
    let depth = min(min(-e0.a.z, -e0.b.z), min(-e1.a.z, -e1.b.z));
    return all(nearest <= vec4f(0.0)) && depth <= shaft.depth * (1.0 + SLACK);
}

// Layers that the shared triangle adds for a receiver: those that turn their front to the light's centre, and the others.
fn layers_of(index: u32, receiver: vec3f) -> vec2u {
    let plane = shared_planes[index];
    let is_front = plane.w >= 0.0;
    if is_before(plane, receiver) == is_front {
        return vec2u(0u);
    }
    let sides = vec3<bool>(
        is_left_of_center(shared_normals[3u * index], receiver),
        is_left_of_center(shared_normals[3u * index + 1u], receiver),
        is_left_of_center(shared_normals[3u * index + 2u], receiver),
    );
    if any(sides == vec3<bool>(is_front)) {
        return vec2u(0u);
    }
    return select(vec2u(0u, 1u), vec2u(1u, 0u), is_front);
}

fn is_left_of_center(normal_and_turn: vec4f, receiver: vec3f) -> bool {
    return side_of_center(normal_and_turn.xyz, receiver) != (normal_and_turn.w > 0.5);
}

// Layers of the triangles in `count` clusters from `first` on, or of those up to a pause.
fn layers_in(lane: u32, receiver: WedgeReceiver, first: u32, count: u32, walk: ptr<function, Walk>) -> vec2u {
    let shaft = shaft_to_center();
    var layers = vec2u(0u);
    for (var start = (*walk).triangle_cluster; start < count; start += LANES) {
        spend(walk, 1u);
        var is_near = false;
        if start + lane < count {
            let cluster = clusters[first + start + lane];
            is_near = box_in_shaft(shaft, cluster.low, cluster.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            let index = start + first_vote(near);
            if must_pause(walk, 1u + LANES) {
                (*walk).triangle_cluster = index;
                return layers;
            }
            let cluster = clusters[first + index];
            let in_shaft = votes(lane, load_triangle(lane, cluster, shaft));
            spend(walk, 1u + vote_count(in_shaft));
            for (var rest = in_shaft; any(rest != vec2u(0u)); rest = without_first_vote(rest)) {
                layers += layers_of(first_vote(rest), receiver.point);
            }
            workgroupBarrier();
        }
    }
    (*walk).triangle_cluster = count;
    return layers;
}

// -- The horizon: a receiver sees nothing of the light that lies below its own plane -----------------------------------

// Height above the receiver's plane of the light's point u, metres: x + y u.x + z u.y.
fn horizon(receiver: WedgeReceiver) -> vec3f {
    return vec3f(-dot(receiver.normal, receiver.point), receiver.normal.xy);
}

// The share of the light above the horizon: the area of a square that a line cuts (papers' O2).
fn share_above_horizon(receiver: WedgeReceiver) -> f32 {
    let height = horizon(receiver);
    if light.is_point == 1u {
        return select(0.0, 1.0, height.x > 0.0);
    }
    let wide = max(abs(height.y), abs(height.z));
    let narrow = min(abs(height.y), abs(height.z));
    if height.x >= wide + narrow {
        return 1.0;
    }
    if height.x <= -wide - narrow {
        return 0.0;
    }
    if narrow < 1e-4 * wide {
        return saturate(0.5 + 0.5 * height.x / wide);
    }
    let corners = max(vec4f(height.x) + vec4f(wide + narrow, wide - narrow, narrow - wide, -wide - narrow), vec4f(0.0));
    let squares = corners * corners;
    return saturate((squares.x - squares.y - squares.z + squares.w) / (8.0 * wide * narrow));
}

// The result. Behind a one-sided light there is darkness; a two-sided one comes twice, and its second side leaves the first's be.
fn write_visibility(receiver: WedgeReceiver, share: f32) {
    if receiver.exists && (receiver.is_lightable || light.is_second_side == 0u) {
        let dark_or_empty = select(1.0, 0.0, receiver.is_surface);
        visibility[receiver.pixel] = select(dark_or_empty, share, receiver.is_lightable);
    }
}
