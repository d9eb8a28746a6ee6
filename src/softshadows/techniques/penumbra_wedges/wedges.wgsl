// Occluders by penumbra wedges: every silhouette's occlusion from its edges, silhouettes blended front to back.
// [Forest2006 §3], [Forest2006 §2] "conventional penumbra-wedges"

//#struct WedgeObject
//#include "layers.wgsl"
//#include "parts.wgsl"
//#include "horizon.wgsl"

@group(2) @binding(1) var<storage, read> objects: array<WedgeObject>;  // from the light outward

const ADDITIVE = 0u;
const PROBABILISTIC = 1u;
const OVERLAP = 2u;

override blending: u32 = OVERLAP;
const EDGE_ROUNDS = 1u;      // of loops that an edge takes: its own
const OBJECT_ROUNDS = 12u;   // that an object takes besides its clusters': over quarters, and to find the clusters

// What a receiver keeps between dispatches.
const STATE_BYTES = 672u;
struct WedgeState {
    walk: vec4u,
    silhouette: array<Part, PARTS>,
    combined: array<Part, PARTS>,
    layers: vec2u,
    occlusion: f32,
};

@group(1) @binding(5) var<storage, read_write> states: array<WedgeState>;

var<private> weights: vec2f;   // of the layers of the object at hand that turn their front, or their back, to the light
var<private> layers: vec2u;    // of the object at hand, between the receiver and the light's centre
var<private> occlusion: f32;   // by all objects before it; not of OVERLAP

fn restore_state(slot: u32) {
    silhouette = states[slot].silhouette;
    combined = states[slot].combined;
    layers = states[slot].layers;
    occlusion = states[slot].occlusion;
}

fn keep_state(slot: u32, walk: vec4u) {
    states[slot] = WedgeState(walk, silhouette, combined, layers, occlusion);
}

// Bring an edge of a cluster into shared memory. Is it a silhouette of the object at hand, in the shaft?
fn load_edge(lane: u32, cluster: WedgeCluster, shaft: Shaft) -> bool {
    if lane >= cluster.count {
        return false;
    }
    var edge = edges[cluster.first + lane];
    edge.front = weights.x * edge.front + weights.y * edge.back;
    shared_edges[lane] = edge;
    return edge.front != 0.0 && segment_in_shaft(shaft, edge.a, edge.b);
}

fn add_shared_edge(index: u32, receiver: vec3f) {
    let edge = shared_edges[index];
    let counter_clockwise = !side_of_center(edge.normal, receiver);
    add_edge(on_light(receiver, edge.a), on_light(receiver, edge.b), counter_clockwise, edge.front);
}

// Layers as a winding number. A closed surface has two layers wherever it hides something.
fn winding_number(object: WedgeObject, layers: vec2u) -> f32 {
    if object.is_closed == 1u {
        return f32((layers.x + layers.y + 1u) / 2u);
    }
    return object.front * f32(layers.x) + object.back * f32(layers.y);
}

// The silhouette of an object, or what of it there is up to a pause.
fn add_object(lane: u32, receiver: WedgeReceiver, object: WedgeObject, walk: ptr<function, Walk>) {
    layers += layers_in(lane, receiver, object.first_triangle_cluster, object.triangle_clusters, walk);
    if (*walk).is_paused {
        return;
    }
    if (*walk).edge_cluster == 0u {
        begin_silhouette(winding_number(object, layers));
    }
    weights = vec2f(object.front, object.back);
    if !is_point(side.light) {
        add_edges(lane, receiver, object.first_edge_cluster, object.edge_clusters, walk);
    }
}

fn blend_object() {
    switch blending {
        case ADDITIVE: { occlusion += silhouette_share(); }
        case PROBABILISTIC: { occlusion = mix(occlusion, 1.0, saturate(silhouette_share())); }
        default: { blend_silhouette(); }
    }
}

// All objects in the tile's shaft, from the light outward, or those up to a pause.
fn add_occluders(lane: u32, receiver: WedgeReceiver, walk: ptr<function, Walk>) {
    let shaft = shaft_to_light();
    for (var start = (*walk).object; start < side.object_count; start += LANES) {
        spend(walk, 1u);
        var is_near = false;
        if start + lane < side.object_count {
            let object = objects[start + lane];
            is_near = box_in_shaft(shaft, object.low, object.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            (*walk).object = start + first_vote(near);
            if must_pause(walk, OBJECT_ROUNDS) {
                return;
            }
            add_object(lane, receiver, objects[(*walk).object], walk);
            if (*walk).is_paused {
                return;
            }
            blend_object();
            spend(walk, OBJECT_ROUNDS);
            (*walk).triangle_cluster = 0u;
            (*walk).edge_cluster = 0u;
            layers = vec2u(0u);
        }
    }
}

fn visible_share(receiver: WedgeReceiver) -> f32 {
    let hidden = select(occlusion, combined_share(), blending == OVERLAP);
    return min(saturate(1.0 - hidden), share_above_horizon(receiver));
}
