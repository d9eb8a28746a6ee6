// How many triangles lie between the receiver and the light's centre.
// The paper draws shadow volumes for it; the result is that of z-fail with an infinite far plane, wherever the camera is.
// [Forest2006 §4.1]

//#include "walk.wgsl"

var<workgroup> shared_normals: array<vec4f, 192>;
var<workgroup> shared_planes: array<vec4f, LANES>;

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
        var near = near_clusters(lane, shaft, first, start, count);
        for (; any(near != vec2u(0u)); near = without_first_vote(near)) {
            let index = start + first_vote(near);
            if must_pause(walk, 1u + LANES) {
                (*walk).triangle_cluster = index;
                return layers;
            }
            let in_shaft = votes(lane, load_triangle(lane, clusters[first + index], shaft));
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
