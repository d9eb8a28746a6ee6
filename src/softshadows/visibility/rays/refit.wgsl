// The boxes of a tree whose shape is known: triangles in the order of the leaves, a pyramid of boxes over them, and every
// node's box from the few pyramid boxes that its triangles fill.

//#include "gpu/scene.wgsl"
//#include "tree_node.wgsl"
//#include "invocation.wgsl"
//#include "world_space.wgsl"

@group(0) @binding(0) var<uniform> tree: TreeGrid;
@group(0) @binding(1) var<storage, read> order: array<u32>;                    // the triangle at every place
@group(0) @binding(2) var<storage, read_write> tree_triangles: array<vec4f>;   // three corners at every place, in the tree's space
@group(0) @binding(3) var<storage, read_write> pyramid: array<vec4u>;          // boxes, one level after the other
@group(0) @binding(4) var<storage, read> shapes: array<vec4u>;                 // by node: first place, end, link, 0
@group(0) @binding(5) var<storage, read_write> tree_nodes: array<vec4u>;

override level = 0u;  // of the pyramid that cs_reduce fills

const FAN = 4u;            // boxes below each box of the pyramid
const ROUNDING = 0.03125;  // cells: more than float32 loses on the way to the grid, and than a ray does on its way through
const EMPTY = vec4u(0xffffu, 0xffffu, 0xffffu, 0u);

fn packed_box(low: vec3f, high: vec3f) -> vec4u {
    return vec4u(vec3u(low) | (vec3u(high) << vec3u(16u)), 0u);
}

fn united(a: vec4u, b: vec4u) -> vec4u {
    let low = min(a.xyz & vec3u(0xffffu), b.xyz & vec3u(0xffffu));
    let high = max(a.xyz >> vec3u(16u), b.xyz >> vec3u(16u));
    return vec4u(low | (high << vec3u(16u)), 0u);
}

// A position on the grid, in cells.
fn on_grid(position_ws: vec3f) -> vec3f {
    return (position_ws - tree.low_ws) * tree.cells_per_metre;
}

@compute @workgroup_size(INVOCATIONS)
fn cs_gather(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let place = invocation(id, groups);
    if place >= tree.triangle_count {
        return;
    }
    let triangle = order[place];
    let vertices = triangle_vertices(triangle);
    let a = tree_space(vertex_position_ws(vertices.x));
    let b = tree_space(vertex_position_ws(vertices.y));
    let c = tree_space(vertex_position_ws(vertices.z));
    tree_triangles[3u * place] = vec4f(a, bitcast<f32>(triangle));
    tree_triangles[3u * place + 1u] = vec4f(b, 0.0);
    tree_triangles[3u * place + 2u] = vec4f(c, 0.0);
    let low = floor(on_grid(min(min(a, b), c)) - ROUNDING);
    let high = ceil(on_grid(max(max(a, b), c)) + ROUNDING);
    pyramid[place] = packed_box(clamp(low, vec3f(0.0), vec3f(65535.0)), clamp(high, vec3f(0.0), vec3f(65535.0)));
}

// Boxes in a level of the pyramid, and where they begin.
fn level_count(at: u32) -> u32 {
    var count = tree.triangle_count;
    for (var i = 0u; i < at; i++) {
        count = (count + FAN - 1u) / FAN;
    }
    return count;
}

fn level_start(at: u32) -> u32 {
    var count = tree.triangle_count;
    var start = 0u;
    for (var i = 0u; i < at; i++) {
        start += count;
        count = (count + FAN - 1u) / FAN;
    }
    return start;
}

@compute @workgroup_size(INVOCATIONS)
fn cs_reduce(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = invocation(id, groups);
    if index >= level_count(level) {
        return;
    }
    let below = level_start(level - 1u);
    let end = min(FAN * index + FAN, level_count(level - 1u));
    var box = pyramid[below + FAN * index];
    for (var i = FAN * index + 1u; i < end; i++) {
        box = united(box, pyramid[below + i]);
    }
    pyramid[level_start(level) + index] = box;
}

// The box around the places from `first` to before `end`: what does not fill a box of the next level, level by level.
fn box_around(first: u32, end: u32) -> vec4u {
    var low = first;
    var high = end;
    var start = 0u;
    var count = tree.triangle_count;
    var box = pyramid[first];
    while low < high {
        while low < high && low % FAN != 0u {
            box = united(box, pyramid[start + low]);
            low++;
        }
        while low < high && high % FAN != 0u {
            high--;
            box = united(box, pyramid[start + high]);
        }
        start += count;
        count = (count + FAN - 1u) / FAN;
        low /= FAN;
        high /= FAN;
    }
    return box;
}

@compute @workgroup_size(INVOCATIONS)
fn cs_bound(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = invocation(id, groups);
    if node >= tree.node_count {
        return;
    }
    let shape = shapes[node];
    tree_nodes[node] = vec4u(box_around(shape.x, shape.y).xyz, shape.z);
}
