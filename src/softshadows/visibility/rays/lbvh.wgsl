// The shape of a tree with a triangle in each leaf, along a space-filling curve, all nodes at once (Karras 2012, "Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees").
//
//     cs_code     where each triangle lies along the curve; then sort.wgsl
//     cs_split    of every inner node: its places in the sorted order, and where its children part
//     cs_number_nodes   every node's place in preorder, and its record; then, once there are boxes, merge.wgsl
//
// Until they have places in preorder, nodes are numbered as in the paper: inner ones from 0, the root, and then the leaves.

//#include "gpu/scene.wgsl"
//#include "tree_node.wgsl"
//#include "lbvh_scratch.wgsl"
//#include "invocation.wgsl"

@group(0) @binding(4) var<storage, read_write> shapes: array<vec4u>;  // refit.wgsl

override LARGE = 0.25;  // sah.py

const IS_FIRST_CHILD = 0x80000000u;
const CELLS_ACROSS = 65536.0;  // of the tree's grid
const CODED_CELLS = 32768.0;
const LARGE_BIT = 0x200000u;

// Eight bits of each coordinate, interleaved from x on.
fn interleaved(coordinates: vec3u) -> u32 {
    var bits = coordinates & vec3u(0xffu);
    bits = (bits | (bits << vec3u(8u))) & vec3u(0x00f00fu);
    bits = (bits | (bits << vec3u(4u))) & vec3u(0x0c30c3u);
    bits = (bits | (bits << vec3u(2u))) & vec3u(0x249249u);
    return bits.x | (bits.y << 1u) | (bits.z << 2u);
}

// A code has 46 bits, the lower 24 in its first word: 15 of each coordinate, in cells that are cubes, so that a flat scene is not
// cut along its flat side; and the highest for large triangles, which the root then parts from the others (sah.py).
@compute @workgroup_size(INVOCATIONS)
fn cs_code(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let triangle = invocation(id, groups);
    if triangle >= tree.triangle_count {
        return;
    }
    let vertices = triangle_vertices(triangle);
    let a = vertex_position_ws(vertices.x) - tree.low_ws;
    let b = vertex_position_ws(vertices.y) - tree.low_ws;
    let c = vertex_position_ws(vertices.z) - tree.low_ws;
    let cells_per_metre = min(min(tree.cells_per_metre.x, tree.cells_per_metre.y), tree.cells_per_metre.z);
    let middle = (a + b + c) / 3.0 * cells_per_metre / CELLS_ACROSS;
    let size = (max(max(a, b), c) - min(min(a, b), c)) * cells_per_metre / CELLS_ACROSS;
    let is_large = max(max(size.x, size.y), size.z) > LARGE;
    let cell = vec3u(clamp(middle * CODED_CELLS, vec3f(0.0), vec3f(CODED_CELLS - 1.0)));
    scratch[code_at(triangle)] = interleaved(cell);
    scratch[code_at(triangle) + 1u] = interleaved(cell >> vec3u(8u)) | select(0u, LARGE_BIT, is_large);
    order[triangle] = triangle;
}

// How many bits the codes at two places have in common from the highest on; equal codes part by their places. -1 past the ends.
fn common_bits(place: i32, other: i32) -> i32 {
    if other < 0 || other >= i32(tree.triangle_count) {
        return -1;
    }
    let a = code_at(order[place]);
    let b = code_at(order[other]);
    let upper = scratch[a + 1u] ^ scratch[b + 1u];
    if upper != 0u {
        return i32(countLeadingZeros(upper));
    }
    let lower = scratch[a] ^ scratch[b];
    if lower != 0u {
        return 32 + i32(countLeadingZeros(lower));
    }
    return 64 + i32(countLeadingZeros(u32(place) ^ u32(other)));
}

@compute @workgroup_size(INVOCATIONS)
fn cs_split(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node + 1u >= tree.triangle_count {
        return;
    }
    // Its places run from here towards the neighbour with more bits in common, as long as there are more of them than the other
    // neighbour has.
    let place = i32(node);
    let direction = select(-1, 1, common_bits(place, place + 1) > common_bits(place, place - 1));
    let outside = common_bits(place, place - direction);
    var most = 2;
    while common_bits(place, place + most * direction) > outside {
        most *= 2;
    }
    var reach = 0;
    for (var jump = most / 2; jump >= 1; jump /= 2) {
        if common_bits(place, place + (reach + jump) * direction) > outside {
            reach += jump;
        }
    }
    let other_end = place + reach * direction;
    // The children part where more bits are in common than all of the node's places have.
    let inside = common_bits(place, other_end);
    var parted = 0;
    var jump = reach;
    while jump > 1 {
        jump = (jump + 1) / 2;
        if common_bits(place, place + (parted + jump) * direction) > inside {
            parted += jump;
        }
    }
    let split = u32(place + parted * direction + min(direction, 0));
    let first = u32(min(place, other_end));
    let last = u32(max(place, other_end));
    let leaves = tree.triangle_count - 1u;  // the number of the first one
    scratch[parent_at(select(split, leaves + split, split == first))] = node | IS_FIRST_CHILD;
    scratch[parent_at(select(split + 1u, leaves + split + 1u, split + 1u == last))] = node;
    scratch[range_at(node)] = first;
    scratch[range_at(node) + 1u] = last;
}

@compute @workgroup_size(INVOCATIONS)
fn cs_number_nodes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node >= tree.node_count {
        return;
    }
    let is_leaf = node + 1u >= tree.triangle_count;
    var first = node + 1u - tree.triangle_count;
    var last = first;
    if !is_leaf {
        first = scratch[range_at(node)];
        last = scratch[range_at(node) + 1u];
    }
    // Before a node in preorder come the nodes above it, and trees over all places before its own, each with one inner node less
    // than leaves. There are as many of them as second children among the node and those above it; the first children remain.
    var number = 2u * first;
    var child = node;
    while child != 0u {
        let parent = scratch[parent_at(child)];
        number += parent / IS_FIRST_CHILD;
        child = parent & ~IS_FIRST_CHILD;
    }
    let skip = number + 2u * (last + 1u - first) - 1u;
    shapes[number] = vec4u(first, last + 1u, select(skip, LEAF | first, is_leaf), 0u);
}
