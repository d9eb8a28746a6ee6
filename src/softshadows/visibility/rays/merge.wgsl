// A tree with a triangle in each leaf gets leaves of up to eight: wherever the surface-area heuristic finds that to test a node's
// triangles costs no more than to go through the boxes below it.
//
//     cs_collapse     which nodes that would be
//     cs_count_remaining      those below them go: the others are counted, block by block
//     cs_sum       blocks after blocks
//     cs_compact  the others close up, in preorder as before
//
// Such a tree has 2t - 1 nodes, and a node over c triangles is followed by the 2c - 2 below it.

//#include "tree_node.wgsl"
//#include "inclusive_scan.wgsl"
//#include "invocation.wgsl"

@group(0) @binding(0) var<uniform> tree: TreeGrid;
@group(0) @binding(1) var<storage, read_write> shapes: array<u32>;      // refit.wgsl, word by word; the last: see cs_count_remaining
@group(0) @binding(2) var<storage, read_write> nodes: array<u32>;       // boxes, and the judgement; then the new shapes
@group(0) @binding(3) var<storage, read_write> remaining_before: array<u32>; // by block: nodes that stay before it; last, all

override NODE_COST = 0.5;     // sah.py

const MOST_IN_LEAF = LEAF_COUNT_MASK + 1u;
const MOST_NODES = 2u * MOST_IN_LEAF - 1u;  // of a tree over so many
const IS_LEAF = 0x80000000u;

fn triangles_in(node: u32) -> u32 {
    return shapes[4u * node + 1u] - shapes[4u * node];
}

// Half of a box's surface, in square metres.
fn half_area(node: u32) -> f32 {
    let box = vec4u(nodes[4u * node], nodes[4u * node + 1u], nodes[4u * node + 2u], 0u);
    let size = (box_high(box) - box_low(box)) / tree.cells_per_metre;
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Is it best for the node to be a leaf, if all below it are as is best for them?
fn is_best_as_leaf(node: u32, count: u32) -> bool {
    var costs: array<f32, MOST_NODES>;
    var is_leaf = false;
    for (var left = 2u * count - 1u; left > 0u; left--) {
        let at = left - 1u;
        let within = triangles_in(node + at);
        let area = half_area(node + at);
        let as_leaf = area * f32(within);
        var as_tree = as_leaf;
        if within > 1u {
            let second = at + 2u * triangles_in(node + at + 1u);
            as_tree = 2.0 * NODE_COST * area + costs[at + 1u] + costs[second];
        }
        is_leaf = as_leaf <= as_tree;
        costs[at] = min(as_leaf, as_tree);
    }
    return is_leaf;
}

// By node: what comes after the nodes that go if it becomes a leaf; 0 if it does not.
@compute @workgroup_size(INVOCATIONS)
fn cs_collapse(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node >= 2u * tree.triangle_count - 1u {
        return;
    }
    let count = triangles_in(node);
    var collapse_end = 0u;
    if count <= MOST_IN_LEAF && is_best_as_leaf(node, count) {
        collapse_end = node + 2u * count - 1u;
    }
    nodes[4u * node + 3u] = collapse_end;
}

fn stays(node: u32) -> bool {
    for (var above = max(node, MOST_NODES - 1u) + 1u - MOST_NODES; above < node; above++) {
        if nodes[4u * above + 3u] > node {
            return false;
        }
    }
    return true;
}

// A node's last word: how many nodes of its block stay before it, and whether it is a leaf.
@compute @workgroup_size(SCAN_LANES)
fn cs_count_remaining(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group.y * groups.x + group.x;
    let node_count = 2u * tree.triangle_count - 1u;
    var before = 0u;
    for (var first = BLOCK * block; first < BLOCK * block + BLOCK; first += SCAN_LANES) {
        let node = first + lane;
        let is_one = node < node_count;
        let counts = select(0u, 1u, is_one && stays(node));
        let sum = inclusive_scan(lane, counts);
        if is_one {
            shapes[4u * node + 3u] = (before + sum - counts) | select(0u, IS_LEAF, nodes[4u * node + 3u] > 0u);
        }
        before += scan_total();
    }
    if lane == 0u && BLOCK * block < node_count {
        remaining_before[block] = before;
    }
}

@compute @workgroup_size(SCAN_LANES)
fn cs_sum(@builtin(local_invocation_index) lane: u32) {
    let blocks = arrayLength(&remaining_before) - 1u;
    var before = 0u;
    for (var first = 0u; first < blocks; first += SCAN_LANES) {
        let block = first + lane;
        var count = 0u;
        if block < blocks {
            count = remaining_before[block];
        }
        let sum = inclusive_scan(lane, count);
        if block < blocks {
            remaining_before[block] = before + sum - count;
        }
        before += scan_total();
    }
    if lane == 0u {
        remaining_before[blocks] = before;
    }
}

// The new number of a node, or of the next one that stays.
fn number_of(node: u32) -> u32 {
    if node >= 2u * tree.triangle_count - 1u {
        return remaining_before[arrayLength(&remaining_before) - 1u];
    }
    return remaining_before[node / BLOCK] + (shapes[4u * node + 3u] & ~IS_LEAF);
}

@compute @workgroup_size(INVOCATIONS)
fn cs_compact(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node >= 2u * tree.triangle_count - 1u || number_of(node) == number_of(node + 1u) {
        return;
    }
    let first = shapes[4u * node];
    let end = shapes[4u * node + 1u];
    var link = LEAF | ((end - first - 1u) << LEAF_COUNT_SHIFT) | first;
    if (shapes[4u * node + 3u] & IS_LEAF) == 0u {
        link = number_of(shapes[4u * node + 2u]);
    }
    let at = 4u * number_of(node);
    nodes[at] = first;
    nodes[at + 1u] = end;
    nodes[at + 2u] = link;
    nodes[at + 3u] = 0u;
}
