// The shape of a tree over triangles along a space-filling curve, all nodes at once (Karras 2012, "Maximizing Parallelism in
// the Construction of BVHs, Octrees, and k-d Trees").
//
//     cs_code     where each triangle lies along the curve; then sort.wgsl
//     cs_split    of every inner node: its leaves, and where they part
//     cs_number   every node's place in preorder, and its record
//
// A leaf is a run of LEAF_TRIANGLES in the sorted order. Inner nodes are numbered as in the paper, the root 0; leaves follow.

//#include "scene.wgsl"
//#include "tree_node.wgsl"
//#struct BuildStep

@group(0) @binding(0) var<uniform> step: BuildStep;
@group(0) @binding(1) var<storage, read_write> order: array<u32>;
@group(0) @binding(2) var<storage, read_write> scratch: array<u32>;  // codes, then as `parent_at` and `range_at` say (lbvh.py)
@group(0) @binding(3) var<storage, read_write> shapes: array<vec4u>;  // refit.wgsl
@group(0) @binding(4) var<uniform> tree: TreeGrid;

override LEAF_TRIANGLES = 4u;

const INVOCATIONS = 64u;
const IS_FIRST_CHILD = 0x80000000u;
const CELLS = 65535.0;

fn invocation(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * INVOCATIONS + id.x;
}

// Two empty bits after each of eight.
fn spread(bits: vec3u) -> vec3u {
    var result = bits & vec3u(0xffu);
    result = (result | (result << vec3u(8u))) & vec3u(0x0000f00fu);
    result = (result | (result << vec3u(4u))) & vec3u(0x000c30c3u);
    return (result | (result << vec3u(2u))) & vec3u(0x00249249u);
}

fn interleaved(bits: vec3u) -> u32 {
    let parts = spread(bits);
    return parts.x | (parts.y << 1u) | (parts.z << 2u);
}

// A code is two words, the lower one first: 24 bits each, of eight a coordinate. Cells are cubes, so that a flat scene is cut
// across its long sides first.
@compute @workgroup_size(INVOCATIONS)
fn cs_code(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = invocation(id, groups);
    if index >= step.count {
        return;
    }
    let triangle = order[step.first_place + index];
    let vertices = triangle_vertices(triangle);
    let a = vertex_position_ws(vertices.x) - tree.low_ws;
    let b = vertex_position_ws(vertices.y) - tree.low_ws;
    let c = vertex_position_ws(vertices.z) - tree.low_ws;
    let cells_per_metre = min(min(tree.cells_per_metre.x, tree.cells_per_metre.y), tree.cells_per_metre.z);
    let cell = vec3u(clamp((a + b + c) / 3.0 * cells_per_metre, vec3f(0.0), vec3f(CELLS)));
    scratch[2u * triangle] = interleaved(cell);
    scratch[2u * triangle + 1u] = interleaved(cell >> vec3u(8u));
}

fn leaf_count() -> u32 {
    return (step.count + LEAF_TRIANGLES - 1u) / LEAF_TRIANGLES;
}

// By node: its parent, with a bit for first children.
fn parent_at(node: u32) -> u32 {
    return step.list_start + node;
}

// By inner node: its first leaf, and its last.
fn range_at(node: u32) -> u32 {
    return step.list_start + 2u * leaf_count() + 2u * node;
}

// How many bits two leaves' codes have in common from the highest on: equal ones part by their places. -1 past the ends.
fn common_bits(leaf: i32, other: i32) -> i32 {
    if other < 0 || other >= i32(leaf_count()) {
        return -1;
    }
    let a = 2u * order[step.first_place + LEAF_TRIANGLES * u32(leaf)];
    let b = 2u * order[step.first_place + LEAF_TRIANGLES * u32(other)];
    let upper = scratch[a + 1u] ^ scratch[b + 1u];
    if upper != 0u {
        return i32(countLeadingZeros(upper));
    }
    let lower = scratch[a] ^ scratch[b];
    if lower != 0u {
        return 32 + i32(countLeadingZeros(lower));
    }
    return 64 + i32(countLeadingZeros(u32(leaf) ^ u32(other)));
}

@compute @workgroup_size(INVOCATIONS)
fn cs_split(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = invocation(id, groups);
    if index + 1u >= leaf_count() {
        return;
    }
    let node = i32(index);
    // The node's leaves: from this one on in the direction of the nearer neighbour, as far as they share more with it than the
    // other neighbour does.
    let direction = select(-1, 1, common_bits(node, node + 1) > common_bits(node, node - 1));
    let outside = common_bits(node, node - direction);
    var most = 2;
    while common_bits(node, node + most * direction) > outside {
        most *= 2;
    }
    var reach = 0;
    for (var jump = most / 2; jump >= 1; jump /= 2) {
        if common_bits(node, node + (reach + jump) * direction) > outside {
            reach += jump;
        }
    }
    let other_end = node + reach * direction;
    // They part where they share more bits than all of them do.
    let shared_bits = common_bits(node, other_end);
    var parted = 0;
    var jump = reach;
    while jump > 1 {
        jump = (jump + 1) / 2;
        if common_bits(node, node + (parted + jump) * direction) > shared_bits {
            parted += jump;
        }
    }
    let split = u32(node + parted * direction + min(direction, 0));
    let first = u32(min(node, other_end));
    let last = u32(max(node, other_end));
    let first_leaf = leaf_count() - 1u;  // as a node
    scratch[parent_at(select(split, first_leaf + split, split == first))] = index | IS_FIRST_CHILD;
    scratch[parent_at(select(split + 1u, first_leaf + split + 1u, split + 1u == last))] = index;
    scratch[range_at(index)] = first;
    scratch[range_at(index) + 1u] = last;
}

@compute @workgroup_size(INVOCATIONS)
fn cs_number(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node + 1u >= 2u * leaf_count() {
        return;
    }
    let is_leaf = node + 1u >= leaf_count();
    var first = node + 1u - leaf_count();
    var last = first;
    if !is_leaf {
        first = scratch[range_at(node)];
        last = scratch[range_at(node) + 1u];
    }
    // Before a node in preorder come the nodes above it, and trees over all leaves before it, each with one inner node less than
    // leaves: the trees are as many as the second children among the node and those above it.
    var place = step.first_node + 2u * first;
    var child = node;
    while child != 0u {
        let parent = scratch[parent_at(child)];
        place += parent / IS_FIRST_CHILD;
        child = parent & ~IS_FIRST_CHILD;
    }
    let first_triangle = step.first_place + LEAF_TRIANGLES * first;
    let end_triangle = step.first_place + min(LEAF_TRIANGLES * (last + 1u), step.count);
    let leaf_link = LEAF | ((end_triangle - first_triangle - 1u) << LEAF_COUNT_SHIFT) | first_triangle;
    let skip = place + 2u * (last + 1u - first) - 1u;
    shapes[place] = vec4u(first_triangle, end_triangle, select(skip, leaf_link, is_leaf), 0u);
}
