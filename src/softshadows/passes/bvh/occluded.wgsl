// Does a triangle lie on a segment? The tree's nodes and triangles: bindings 5 to 7 of bind group 2.

//#include "node.wgsl"

@group(2) @binding(5) var<uniform> tree: TreeGrid;
@group(2) @binding(6) var<storage, read> tree_nodes: array<vec4u>;
@group(2) @binding(7) var<storage, read> tree_triangles: array<vec4f>;  // three corners each, the number in the first's w

const EDGE_ULPS = 1.2e-7;
const SMALLEST_STEP = 1e-20;

// A segment from `origin` to origin + until × ray, world space.
struct Segment {
    origin: vec3f,
    ray: vec3f,
    until: f32,
};

// Where a line meets a plane beside it nothing is divided by zero, and no 0 × ∞ appears.
fn away_from_zero(v: vec3f) -> vec3f {
    return select(v, select(vec3f(-SMALLEST_STEP), vec3f(SMALLEST_STEP), v >= vec3f(0.0)), abs(v) < vec3f(SMALLEST_STEP));
}

// Edge by edge: on which side of the edge does the line pass? Two triangles that share an edge compute the same number
// with opposite signs, so that no line passes between them (Woop et al. 2013; Embree's robust variant by Plücker coordinates).
fn meets_triangle(segment: Segment, place: u32) -> bool {
    let a = tree_triangles[3u * place].xyz - segment.origin;
    let b = tree_triangles[3u * place + 1u].xyz - segment.origin;
    let c = tree_triangles[3u * place + 2u].xyz - segment.origin;
    let sides = vec3f(
        dot(cross(c + a, c - a), segment.ray),
        dot(cross(a + b, a - b), segment.ray),
        dot(cross(b + c, b - c), segment.ray),
    );
    let tolerance = EDGE_ULPS * abs(sides.x + sides.y + sides.z);
    let least = min(min(sides.x, sides.y), sides.z);
    let most = max(max(sides.x, sides.y), sides.z);
    if least < -tolerance && most > tolerance {
        return false;
    }
    let normal = cross(c - a, a - b);
    let along = dot(normal, segment.ray);
    let reached = dot(normal, a) * sign(along);
    return along != 0.0 && reached >= 0.0 && reached <= segment.until * abs(along);
}

fn is_blocked(segment: Segment) -> bool {
    let step = 1.0 / away_from_zero(segment.ray * tree.cells_per_metre);
    let start = (segment.origin - tree.low_ws) * tree.cells_per_metre * step;
    var node = 0u;
    while node < tree.node_count {
        let record = tree_nodes[node];
        let low = box_low(record) * step - start;
        let high = box_high(record) * step - start;
        let near = min(low, high);
        let far = max(low, high);
        let is_met = max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, segment.until));
        let is_leaf = record.w >= LEAF;
        if is_met && is_leaf {
            let first = record.w & LEAF_FIRST_MASK;
            let end = first + ((record.w >> LEAF_COUNT_SHIFT) & LEAF_COUNT_MASK) + 1u;
            for (var place = first; place < end; place++) {
                if meets_triangle(segment, place) {
                    return true;
                }
            }
        }
        node = select(record.w, node + 1u, is_met || is_leaf);
    }
    return false;
}
