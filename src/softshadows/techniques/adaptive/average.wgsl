// The visible share of the light: the look-ups' bits, weighted by what their samples stand for in the pixel's tree.

//#include "lights/light.wgsl"
//#include "weights.wgsl"

@group(2) @binding(0) var<storage, read> light: Light;
@group(2) @binding(1) var<storage, read_write> visibility: array<f32>;

// Visible corners of a row's leaves, each as often as it has leaves.
fn visible_leaf_corners(tile: u32, lane: u32, level: u32, row: u32, leaves: u32) -> u32 {
    let rows = sample_rows(level, row);
    let low = row_bits(tile, rows.x, lane);
    let high = row_bits(tile, rows.y, lane);
    let right = leaves << right_shift(level);
    return countOneBits(low & leaves) + countOneBits(low & right) + countOneBits(high & leaves) + countOneBits(high & right);
}

// The trapezoid rule: a quarter of each leaf's area to each of its corners. In quarters of the deepest level's cell.
fn sum_by_area(tile: u32, tree: u32, lane: u32, level: u32) -> f32 {
    var visible = 0u;
    for (var row = 0u; row < cell_rows(level); row++) {
        let leaves = leaf_cells(tree, level, row);
        if leaves != 0u {
            visible += visible_leaf_corners(tile, lane, level, row, leaves);
        }
    }
    return cell_area(level) * f32(visible);
}

// Samples in a row that are corners of a level's leaves.
fn corners_of_leaves(tree: u32, level: u32, row: u32) -> u32 {
    if row % spacing(level) != 0u {
        return 0u;
    }
    let cell_row = select(0u, row / spacing(level), shape.has_rows == 1u);
    var leaves = 0u;
    if cell_row < cell_rows(level) {
        leaves |= leaf_cells(tree, level, cell_row);
    }
    if cell_row > 0u {
        leaves |= leaf_cells(tree, level, cell_row - 1u);
    }
    return leaves | (leaves << right_shift(level));
}

// Between leaves of different depth, which the paper leaves open, a sample takes the weight of the deepest.
fn sum_by_paper(tile: u32, tree: u32, lane: u32, level: u32) -> vec2f {
    var sums = vec2u(0u);
    for (var row = 0u; row < shape.sample_rows; row++) {
        var samples = corners_of_leaves(tree, level, row);
        for (var deeper = level + 1u; deeper <= shape.deepest; deeper++) {
            samples &= ~corners_of_leaves(tree, deeper, row);
        }
        sums += vec2u(countOneBits(samples & row_bits(tile, row, lane)), countOneBits(samples));
    }
    return paper_weight(level) * vec2f(sums);
}

@compute @workgroup_size(TILE, TILE)
fn cs_average(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = tree_pixel(group.xy, local.xy);
    let receivers = receivers_of_tile(pixel.receiver, lane);
    if lane == 0u {
        count_lookups(pixel.tree, receivers);
        if pixel.tile == 0u {
            report_rays();
        }
    }
    if !pixel.exists {
        return;
    }
    if !pixel.receiver.is_surface || !is_active(pixel.tree) {
        visibility[pixel.receiver.index] = visibility_without_tree(pixel.receiver);
        return;
    }
    let change = select(0.0, visibility[pixel.receiver.index], shape.has_brackets == 1u);  // bracket.wgsl
    var visible = 0.0;
    var total = 0.0;
    for (var level = 0u; level <= shape.deepest; level++) {
        if paper_weights {
            let sums = sum_by_paper(pixel.tile, pixel.tree, lane, level);
            visible += sums.x;
            total += sums.y;
        } else {
            visible += sum_by_area(pixel.tile, pixel.tree, lane, level);
        }
    }
    if !paper_weights {
        total = 4.0 * cell_area(0u);
    }
    visibility[pixel.receiver.index] = visible / total + change;
}
