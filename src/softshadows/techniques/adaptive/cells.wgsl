// Rows of a tree's cells, for kernels that only read them.

//#needs children_of, parent_row, refined_index, request_index, shape

@group(3) @binding(1) var<storage, read> trees: array<u32>;

fn is_active(tree: u32) -> bool {
    return trees[request_index(tree, 0u)] != 0u;
}

// The cells of a level's row whose parents are refined.
fn present_cells(tree: u32, level: u32, row: u32) -> u32 {
    if level == 0u {
        return select(0u, 1u, is_active(tree));
    }
    return children_of(trees[refined_index(tree, level - 1u, parent_row(row))], level);
}

fn leaf_cells(tree: u32, level: u32, row: u32) -> u32 {
    var cells = present_cells(tree, level, row);
    if level < shape.deepest {
        cells &= ~trees[refined_index(tree, level, row)];
    }
    return cells;
}
