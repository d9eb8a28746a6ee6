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

// All edges of an object.
fn add_edges(lane: u32, receiver: WedgeReceiver, object: WedgeObject) {
    let shaft = shaft_to_light();
    for (var start = 0u; start < object.edge_clusters; start += LANES) {
        var is_near = false;
        if start + lane < object.edge_clusters {
            let cluster = edge_clusters[object.first_edge_cluster + start + lane];
            is_near = box_in_shaft(shaft, cluster.low, cluster.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            let cluster = edge_clusters[object.first_edge_cluster + start + first_vote(near)];
            for (var rest = votes(lane, load_edge(lane, cluster, shaft, object)); any(rest != vec2u(0u)); rest = without_first_vote(rest)) {
                work += 1u;
                let edge = shared_edges[first_vote(rest)];
                let counter_clockwise = !side_of_center(edge.normal, receiver.point);
                add_edge(on_light(receiver.point, edge.a), on_light(receiver.point, edge.b), counter_clockwise, edge.front);
            }
            workgroupBarrier();
        }
    }
}

// Layers as a winding number. A closed surface has two layers wherever it hides something.
fn winding_number(object: WedgeObject, layers: vec2u) -> f32 {
    if object.is_closed == 1u {
        return f32((layers.x + layers.y + 1u) / 2u);
    }
    return object.front * f32(layers.x) + object.back * f32(layers.y);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let receiver = wedge_receiver(group.xy, local.xy);
    gather_shafts(lane, receiver);
    let shaft = shaft_to_light();
    begin_combined();
    var occlusion = 0.0;
    var transmission = 1.0;
    for (var start = 0u; start < light.object_count; start += LANES) {
        var is_near = false;
        if start + lane < light.object_count {
            let object = objects[start + lane];
            is_near = box_in_shaft(shaft, object.low, object.high);
        }
        for (var near = votes(lane, is_near); any(near != vec2u(0u)); near = without_first_vote(near)) {
            let object = objects[start + first_vote(near)];
            let layers = layers_in(lane, receiver, object.first_triangle_cluster, object.triangle_clusters);
            begin_silhouette(winding_number(object, layers));
            if light.is_point == 0u {
                add_edges(lane, receiver, object);
            }
            switch blending {
                case ADDITIVE: { occlusion += silhouette_share(); }
                case PROBABILISTIC: { transmission *= 1.0 - saturate(silhouette_share()); }
                default: { blend_silhouette(); }
            }
        }
    }
    if blending == PROBABILISTIC {
        occlusion = 1.0 - transmission;
    } else if blending == OVERLAP {
        occlusion = combined_share();
    }
    write_visibility(receiver, min(saturate(1.0 - occlusion), share_above_horizon(receiver)));
}
