// Once per frame and light: planes, edges and clusters in light units, and which edges are silhouettes.
// [Forest2006 §4.1] "silhouette edges selection", here for all edges at once.

//#include "gpu/scene.wgsl"
//#include "light_frame.wgsl"

@group(0) @binding(0) var<storage, read> side: WedgeSide;
@group(2) @binding(0) var<storage, read> edge_records: array<vec4u>;       // edge_buffers.py
@group(2) @binding(1) var<storage, read> triangle_records: array<vec4u>;
@group(2) @binding(2) var<storage, read> cluster_ranges: array<vec2u>;     // first edge, how many; then the same of triangles
@group(2) @binding(3) var<storage, read_write> planes: array<vec4f>;       // by triangle; a point in front is positive
@group(2) @binding(4) var<storage, read_write> edges: array<WedgeEdge>;
@group(2) @binding(5) var<storage, read_write> clusters: array<WedgeCluster>;  // as cluster_ranges
@group(2) @binding(6) var<storage, read_write> light_is_cut: atomic<u32>;  // by a triangle

// Are silhouettes those of the light's centre, or of any of its points? [Laine2005 §4]
override from_every_sample: bool = false;

const CLUSTER = 64u;           // edges or triangles that are looked at together, one for each lane
const GROUPS_PER_ROW = 32768u;  // of a dispatch
const FAR = 3e38;

var<workgroup> lowest: array<vec3f, CLUSTER>;
var<workgroup> highest: array<vec3f, CLUSTER>;

fn vertex_in_light_units(vertex: u32) -> vec3f {
    return to_light_units(vertex_position_ws(vertex) - side.center_ws);
}

@compute @workgroup_size(CLUSTER)
fn cs_planes(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let triangle = linear_group(group) * CLUSTER + lane;
    if triangle >= arrayLength(&planes) {
        return;
    }
    let normal = normal_in_light_units(face_normal_ws(triangle));
    planes[triangle] = vec4f(normal, -dot(normal, vertex_in_light_units(triangle_indices[3u * triangle])));
}

// Dispatches are folded into rows, since one dimension holds 65535 groups at most.
fn linear_group(group: vec3u) -> u32 {
    return group.y * GROUPS_PER_ROW + group.x;
}

// +1 where the triangle lies to the left of the edge as its receivers see it, -1 to the right, 0 without a triangle; as the
// light's centre sees the triangle, left and right are the other way round.
fn side_seen_from_center(side: u32, front_only: bool) -> f32 {
    if side == 0u {
        return 0.0;
    }
    let is_front = planes[(side >> 1u) - 1u].w >= 0.0;
    let turns = select(1.0, -1.0, (side & 1u) == 1u) * select(-1.0, 1.0, is_front);
    return select(0.0, turns, is_front == front_only);
}

// Does the plane cut the light? Then the triangle turns its other side to some of it.
fn cuts_light(side: u32) -> bool {
    if side == 0u {
        return false;
    }
    let plane = planes[(side >> 1u) - 1u];
    return abs(plane.w) <= abs(plane.x) + abs(plane.y);
}

@compute @workgroup_size(CLUSTER)
fn cs_edges(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let cluster = linear_group(group);
    if cluster >= side.edge_cluster_count {
        return;
    }
    let range = cluster_ranges[cluster];
    begin_box(lane);
    if lane < range.y {
        let record = edge_records[range.x + lane];
        var a = vertex_in_light_units(record.x);
        var b = vertex_in_light_units(record.y);
        let normal = cross(a, b);

        // What lies behind the light hides none of it.
        let is_behind = a.z >= 0.0 && b.z >= 0.0;
        if a.z > 0.0 && b.z < 0.0 {
            a = vec3f(mix(a, b, a.z / (a.z - b.z)).xy, 0.0);
        } else if b.z > 0.0 && a.z < 0.0 {
            b = vec3f(mix(b, a, b.z / (b.z - a.z)).xy, 0.0);
        }
        let front = side_seen_from_center(record.z, true) + side_seen_from_center(record.w, true);
        let back = side_seen_from_center(record.z, false) + side_seen_from_center(record.w, false);
        let changes = abs(front) + abs(back) > 0.0
            || (from_every_sample && (cuts_light(record.z) || cuts_light(record.w)));
        let is_silhouette = changes && !is_behind;
        edges[range.x + lane] = WedgeEdge(
            a, select(0.0, front, is_silhouette), b, select(0.0, back, is_silhouette), normal, u32(is_silhouette),
        );
        if is_silhouette {
            lowest[lane] = min(a, b);
            highest[lane] = max(a, b);
        }
    }
    write_cluster(cluster, lane, range);
}

@compute @workgroup_size(CLUSTER)
fn cs_triangles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let cluster = side.edge_cluster_count + linear_group(group);
    if linear_group(group) >= side.triangle_cluster_count {
        return;
    }
    let range = cluster_ranges[cluster];
    begin_box(lane);
    if lane < range.y {
        let vertices = triangle_vertices(triangle_records[range.x + lane].w);
        let a = vertex_in_light_units(vertices.x);
        let b = vertex_in_light_units(vertices.y);
        let c = vertex_in_light_units(vertices.z);
        lowest[lane] = min(a, min(b, c));
        highest[lane] = max(a, max(b, c));
        if cuts_light_area(a, b, c) {
            atomicStore(&light_is_cut, 1u);
        }
    }
    write_cluster(cluster, lane, range);
}

// Where the edge from `a` to `b` meets the light's plane. Used only where it does.
fn on_light_plane(a: vec3f, b: vec3f) -> vec2f {
    return mix(a, b, a.z / (a.z - b.z)).xy;
}

// Does the triangle meet the light itself? Its section with the light's plane is a segment, which meets a square unless both ends
// lie beyond one side, or all corners of the square on one side of the segment's line.
fn cuts_light_area(a: vec3f, b: vec3f, c: vec3f) -> bool {
    let is_behind = vec3f(a.z, b.z, c.z) >= vec3f(0.0);
    if all(is_behind) || !any(is_behind) {
        return false;
    }
    // `alone` lies on one side of the light's plane, the others on the other.
    var alone = c;
    var others = array<vec3f, 2>(a, b);
    if is_behind.x != is_behind.y && is_behind.x != is_behind.z {
        alone = a;
        others = array<vec3f, 2>(b, c);
    } else if is_behind.y != is_behind.x && is_behind.y != is_behind.z {
        alone = b;
        others = array<vec3f, 2>(c, a);
    }
    let start = on_light_plane(alone, others[0]);
    let end = on_light_plane(alone, others[1]);
    if any((min(start, end) > vec2f(1.0)) | (max(start, end) < vec2f(-1.0))) {
        return false;
    }
    let along = end - start;
    return abs(start.x * along.y - start.y * along.x) <= abs(along.x) + abs(along.y);
}

// A lane's box, around nothing.
fn begin_box(lane: u32) {
    lowest[lane] = vec3f(FAR);
    highest[lane] = vec3f(-FAR);
}

// The box around all lanes' boxes.
fn write_cluster(cluster: u32, lane: u32, range: vec2u) {
    for (var step = CLUSTER / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if lane < step {
            lowest[lane] = min(lowest[lane], lowest[lane + step]);
            highest[lane] = max(highest[lane], highest[lane + step]);
        }
    }
    if lane == 0u {
        clusters[cluster] = WedgeCluster(lowest[0], range.x, highest[0], range.y);
    }
}
