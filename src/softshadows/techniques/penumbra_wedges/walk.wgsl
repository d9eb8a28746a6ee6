// All lanes of a tile walk together over clusters, 64 at a time, and over the edges in those that are in the shaft. A walk pauses
// where a dispatch may not end it (gpu/driver.wgsl), and receivers keep what they know (dispatches.py).
//
// The including file declares `EDGE_ROUNDS`, the rounds of loops that an edge may take, and
//     load_edge(lane, cluster, shaft)        bring an edge of a cluster into `shared_edges`; is it a silhouette in the shaft?
//     add_shared_edge(index, receiver)       take it in

//#needs EDGE_ROUNDS, add_shared_edge, load_edge
//#include "gpu/driver.wgsl"
//#include "shaft.wgsl"

override is_in_parts: bool = false;  // may one dispatch not be enough?

struct Walk {
    object: u32,            // that the tile is at
    triangle_cluster: u32,  // the object's next ones
    edge_cluster: u32,
    is_done: bool,
    is_paused: bool,
    rounds: u32,            // that this dispatch has left
};

var<workgroup> kept_walk: vec4u;
var<workgroup> ballot: array<atomic<u32>, 2>;
var<workgroup> ballot_result: vec2u;
var<workgroup> shared_edges: array<WedgeEdge, LANES>;

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

// Pause the walk where `most` further rounds may be too many.
fn must_pause(walk: ptr<function, Walk>, most: u32) -> bool {
    (*walk).is_paused = (*walk).rounds < most;
    return (*walk).is_paused;
}

fn spend(walk: ptr<function, Walk>, rounds: u32) {
    (*walk).rounds = rounds_after((*walk).rounds, rounds);
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

// Which of the 64 clusters from `start` on are in the shaft, of `count` from `first` on.
fn near_clusters(lane: u32, shaft: Shaft, first: u32, start: u32, count: u32) -> vec2u {
    var is_near = false;
    if start + lane < count {
        let cluster = clusters[first + start + lane];
        is_near = box_in_shaft(shaft, cluster.low, cluster.high);
    }
    return votes(lane, is_near);
}

// Take in the edges of `count` clusters from `first` on, or of those up to a pause.
fn add_edges(lane: u32, receiver: WedgeReceiver, first: u32, count: u32, walk: ptr<function, Walk>) {
    let shaft = shaft_to_light();
    for (var start = (*walk).edge_cluster; start < count; start += LANES) {
        spend(walk, 1u);
        var near = near_clusters(lane, shaft, first, start, count);
        for (; any(near != vec2u(0u)); near = without_first_vote(near)) {
            let index = start + first_vote(near);
            if must_pause(walk, 1u + LANES * EDGE_ROUNDS) {
                (*walk).edge_cluster = index;
                return;
            }
            let in_shaft = votes(lane, load_edge(lane, clusters[first + index], shaft));
            spend(walk, 1u + vote_count(in_shaft) * EDGE_ROUNDS);
            for (var rest = in_shaft; any(rest != vec2u(0u)); rest = without_first_vote(rest)) {
                if receiver.is_lightable {
                    add_shared_edge(first_vote(rest), receiver.point);
                }
            }
            workgroupBarrier();
        }
    }
    (*walk).edge_cluster = count;
}
