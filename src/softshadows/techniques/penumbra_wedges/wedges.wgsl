// Visibility by penumbra wedges: every silhouette's occlusion from its edges, silhouettes blended front to back.
// [Forest2006 §3], [Forest2006 §2] "conventional penumbra-wedges"

//#struct WedgeObject
//#include "shaft.wgsl"
//#include "parts.wgsl"

@group(2) @binding(1) var<storage, read> objects: array<WedgeObject>;  // from the light outward

const ADDITIVE = 0u;
const PROBABILISTIC = 1u;
const OVERLAP = 2u;

override blending: u32 = OVERLAP;
override object_rounds: u32 = 12;  // of loops that an object takes besides its clusters' (dispatches.py)

// What a receiver keeps between dispatches.
struct WedgeState {
    walk: vec4u,
    silhouette: array<Part, PARTS>,
    combined: array<Part, PARTS>,
    layers: vec2u,
    occlusion: f32,
};

@group(1) @binding(5) var<storage, read_write> states: array<WedgeState>;

var<private> layers: vec2u;    // between the receiver and the light's centre, of the object at hand
var<private> occlusion: f32;   // by all objects before it; not of OVERLAP

// Bring an edge of a cluster into shared memory. Is it a silhouette of the object, in the shaft?
fn load_edge(lane: u32, cluster: WedgeCluster, shaft: Shaft, object: WedgeObject) -> bool {
    if lane >= cluster.count {
        return false;
    }
    var edge = edges[cluster.first + lane];
    edge.front = object.front * edge.front + object.back * edge.back;
    shared_edges[lane] = edge;
    return edge.front != 0.0 && segment_in_shaft(shaft, edge.a, edge.b);
}

// All edges of an object, or those up to a pause.
fn add_edges(lane: u32, receiver: WedgeReceiver, object: WedgeObject, walk: ptr<function, Walk>) {
    let shaft = shaft_to_light();
    for (var start = (*walk).edge_cluster; start < object.edge_clusters; start += LANES) {
        spend(walk, 1u);
        var is_near = false;
        if start + lane < object.edge_clusters {
            let cluster = clusters[object.first_edge_cluster + start + lane];
            is_near = box_in_shaft(shaft, cluster.low, cluster.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            let index = start + first_vote(near);
            if must_pause(walk, 1u + LANES) {
                (*walk).edge_cluster = index;
                return;
            }
            let cluster = clusters[object.first_edge_cluster + index];
            let in_shaft = votes(lane, load_edge(lane, cluster, shaft, object));
            spend(walk, 1u + vote_count(in_shaft));
            for (var rest = in_shaft; any(rest != vec2u(0u)); rest = without_first_vote(rest)) {
                let edge = shared_edges[first_vote(rest)];
                let counter_clockwise = !side_of_center(edge.normal, receiver.point);
                add_edge(on_light(receiver.point, edge.a), on_light(receiver.point, edge.b), counter_clockwise, edge.front);
            }
            workgroupBarrier();
        }
    }
    (*walk).edge_cluster = object.edge_clusters;
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
    if light.is_point == 0u {
        add_edges(lane, receiver, object, walk);
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
fn add_objects(lane: u32, receiver: WedgeReceiver, walk: ptr<function, Walk>) {
    let shaft = shaft_to_light();
    for (var start = (*walk).object; start < light.object_count; start += LANES) {
        spend(walk, 1u);
        var is_near = false;
        if start + lane < light.object_count {
            let object = objects[start + lane];
            is_near = box_in_shaft(shaft, object.low, object.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            (*walk).object = start + first_vote(near);
            if must_pause(walk, object_rounds) {
                return;
            }
            add_object(lane, receiver, objects[(*walk).object], walk);
            if (*walk).is_paused {
                return;
            }
            blend_object();
            spend(walk, object_rounds);
            (*walk).triangle_cluster = 0u;
            (*walk).edge_cluster = 0u;
            layers = vec2u(0u);
        }
    }
}

@compute @workgroup_size(8, 8)
fn cs_visibility(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = state_index(group.xy, lane);
    var kept = vec4u(0u);
    if is_in_parts {
        kept = states[slot].walk;
    }
    var walk = begin_walk(lane, kept);
    if walk.is_done {
        return;
    }
    if is_in_parts {
        silhouette = states[slot].silhouette;
        combined = states[slot].combined;
        layers = states[slot].layers;
        occlusion = states[slot].occlusion;
    }
    let receiver = wedge_receiver(group.xy, local.xy);
    gather_shafts(lane, receiver);
    add_objects(lane, receiver, &walk);
    if is_in_parts {
        states[slot] = WedgeState(kept_of(walk), silhouette, combined, layers, occlusion);
    }
    if !walk.is_paused {
        let hidden = select(occlusion, combined_share(), blending == OVERLAP);
        write_visibility(receiver, min(saturate(1.0 - hidden), share_above_horizon(receiver)));
    }
}
