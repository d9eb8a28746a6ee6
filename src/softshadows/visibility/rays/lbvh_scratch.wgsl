// What a build keeps beside the tree, all in one buffer that is free until the refit (lbvh.py).

//#struct TreeGrid

@group(0) @binding(0) var<uniform> tree: TreeGrid;
@group(0) @binding(1) var<storage, read_write> scratch: array<u32>;
@group(0) @binding(3) var<storage, read_write> order: array<u32>;  // the triangle at every place

// By triangle: its code, two words.
fn code_at(triangle: u32) -> u32 {
    return 2u * triangle;
}

// While it sorts: the other list of triangles, and the counts.
fn list_start() -> u32 {
    return 2u * tree.triangle_count;
}

fn counts_start() -> u32 {
    return 3u * tree.triangle_count;
}

// Afterwards. By node: its parent, with a bit for first children.
fn parent_at(node: u32) -> u32 {
    return 2u * tree.triangle_count + node;
}

// By inner node: its first place, and its last.
fn range_at(node: u32) -> u32 {
    return 4u * tree.triangle_count + 2u * node;
}
