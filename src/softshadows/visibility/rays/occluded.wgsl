// Which of four segments from one point does a triangle block? Four share what is read of the tree, since the points of a
// light that a receiver looks at lie close together: twice as fast as one by one. Bindings 7 to 9 of bind group 1 (bvh.py).

//#include "tree_node.wgsl"
//#include "cutouts.wgsl"

@group(1) @binding(7) var<uniform> tree: TreeGrid;
@group(1) @binding(8) var<storage, read> tree_nodes: array<vec4u>;
@group(1) @binding(9) var<storage, read> tree_triangles: array<vec4f>;  // three corners each, world space; number in the first's w

const ROUNDING = 1.2e-7;        // of float32
const SMALLEST_STEP = 1e-20;    // cells: a ray along an axis would divide by zero
const NOWHERE = 0xffffffffu;

// Four segments from `origin_ws`: its rays, in metres, component by component, and how much of each counts, as a share.
// A negative share is a segment that nobody asks about, or that is known to be blocked.
struct Packet {
    origin_ws: vec3f,
    x: vec4f,
    y: vec4f,
    z: vec4f,
    t_max: vec4f,
};

// The place of the triangle that blocked something last: often it blocks the next packet too.
var<private> last_blocker = NOWHERE;
// Did the device end a walk before its end? Software drivers bound the rounds of an invocation's loops.
var<private> was_cut_short = false;

fn along_rays(packet: Packet, v: vec3f) -> vec4f {
    return v.x * packet.x + v.y * packet.y + v.z * packet.z;
}

fn inverse(steps: vec4f) -> vec4f {
    let is_small = abs(steps) < vec4f(SMALLEST_STEP);
    return 1.0 / select(steps, select(vec4f(-SMALLEST_STEP), vec4f(SMALLEST_STEP), steps >= vec4f(0.0)), is_small);
}

// Where rays pass a triangle: on which side of its edges. All of one sign: through the triangle.
struct Passing {
    edge_a: vec4f,
    edge_b: vec4f,
    edge_c: vec4f,
    is_hit: vec4<bool>,
    triangle: u32,
};

// Two triangles that share an edge compute the same number for it, with opposite signs, so that no ray passes between them
// (Woop et al. 2013, by Plücker coordinates as in Embree's robust mode).
fn pass_triangle(packet: Packet, place: u32) -> Passing {
    let first = tree_triangles[3u * place];
    let a = first.xyz - packet.origin_ws;
    let b = tree_triangles[3u * place + 1u].xyz - packet.origin_ws;
    let c = tree_triangles[3u * place + 2u].xyz - packet.origin_ws;
    let edge_b = along_rays(packet, cross(c + a, c - a));
    let edge_c = along_rays(packet, cross(a + b, a - b));
    let edge_a = along_rays(packet, cross(b + c, b - c));
    let tolerance = ROUNDING * abs(edge_a + edge_b + edge_c);
    let least = min(min(edge_a, edge_b), edge_c);
    let most = max(max(edge_a, edge_b), edge_c);
    let is_through = (least >= -tolerance) | (most <= tolerance);

    let normal = cross(c - a, a - b);
    let slope = along_rays(packet, normal);
    let reached = dot(normal, a) * sign(slope);
    let is_between = (reached >= vec4f(0.0)) & (reached <= packet.t_max * abs(slope)) & (slope != vec4f(0.0));
    return Passing(edge_a, edge_b, edge_c, is_through & is_between, bitcast<u32>(first.w));
}

// The packet's shares once the triangle at `place` has blocked what it blocks.
fn blocked_by(packet: Packet, place: u32) -> vec4f {
    let passing = pass_triangle(packet, place);
    let sum = passing.edge_a + passing.edge_b + passing.edge_c;
    let is_hit = exists_at(passing.triangle, passing.is_hit, passing.edge_b / sum, passing.edge_c / sum);
    return select(packet.t_max, vec4f(-1.0), is_hit);
}

// Those of the packet's segments that are open to the end.
//
// Loops, not branches, hold what is rarer: hits in the outer one, triangles in the next, boxes innermost, so that no triangle is
// tested for each box, and no texture read for each triangle (gpu/driver.wgsl).
fn trace_visibility(asked: Packet) -> vec4<bool> {
    var packet = asked;
    if last_blocker != NOWHERE {
        packet.t_max = blocked_by(packet, last_blocker);
    }
    let origin = (packet.origin_ws - tree.low_ws) * tree.cells_per_metre;
    let step_x = inverse(packet.x * tree.cells_per_metre.x);
    let step_y = inverse(packet.y * tree.cells_per_metre.y);
    let step_z = inverse(packet.z * tree.cells_per_metre.z);
    var node = 0u;
    var place = 0u;    // of the next triangle, in a leaf whose triangles end
    var end = 0u;      // here
    var is_walking = any(packet.t_max >= vec4f(0.0));
    while is_walking {
        var is_hit = false;
        while is_walking && !is_hit {
            while place == end && node < tree.node_count {
                let box = tree_nodes[node];
                let low = box_low(box) - origin;
                let high = box_high(box) - origin;
                let near_x = min(low.x * step_x, high.x * step_x);
                let near_y = min(low.y * step_y, high.y * step_y);
                let near_z = min(low.z * step_z, high.z * step_z);
                let far_x = max(low.x * step_x, high.x * step_x);
                let far_y = max(low.y * step_y, high.y * step_y);
                let far_z = max(low.z * step_z, high.z * step_z);
                let enters = max(max(near_x, near_y), max(near_z, vec4f(0.0)));
                let leaves = min(min(far_x, far_y), min(far_z, packet.t_max));
                let is_met = any(enters <= leaves);
                let is_leaf = box.w >= LEAF;
                place = select(0u, leaf_first(box), is_met && is_leaf);
                end = select(0u, leaf_end(box), is_met && is_leaf);
                node = select(box.w, node + 1u, is_met || is_leaf);
            }
            while place < end && !is_hit {
                is_hit = any(pass_triangle(packet, place).is_hit);
                place += select(1u, 0u, is_hit);
            }
            is_walking = is_hit || place < end || node < tree.node_count;
        }
        if is_hit {
            let t_max = blocked_by(packet, place);
            last_blocker = select(last_blocker, place, any(t_max != packet.t_max));
            packet.t_max = t_max;
            place += 1u;
            is_walking = any(packet.t_max >= vec4f(0.0)) && (place < end || node < tree.node_count);
        }
    }
    was_cut_short |= is_walking;
    return packet.t_max >= vec4f(0.0);
}
