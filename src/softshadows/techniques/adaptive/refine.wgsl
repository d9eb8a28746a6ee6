// Refine the cells that failed, and request the samples at their children's corners. [Schwaerzler2012 §3.3.4]

//#include "tree.wgsl"
//#include "level.wgsl"
//#include "probes.wgsl"

@group(3) @binding(1) var<storage, read_write> trees: array<u32>;
@group(3) @binding(3) var<storage, read> failures: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;
@group(3) @binding(9) var<storage, read> counts: array<u32>;

@group(3) @binding(12) var<storage, read> probes: array<u32>;

const INVOCATIONS = 64u;

fn present_cells(tree: u32, row: u32) -> u32 {
    if step.level == 0u {
        return 1u;
    }
    return children_of(trees[refined_index(tree, step.level - 1u, parent_row(row))], step.level);
}

// Those of the cells that fail in more texels of a tile than may.
fn beyond_threshold(tree: u32, row: u32, failing: u32) -> u32 {
    var found = failing;
    if shape.threshold > 0u {
        for (var rest = failing; rest != 0u; rest &= rest - 1u) {
            let cell = firstTrailingBit(rest);
            found &= ~select(0u, 1u << cell, counts[count_index(tree, step.level, row, cell)] <= shape.threshold);
        }
    }
    return found;
}

// Cells that fail in a tile.
fn failing_cells(tree: u32, row: u32) -> u32 {
    var failing = 0u;
    for (var quadrant = 0u; quadrant < QUADRANTS; quadrant++) {
        failing |= failures[failure_index(tree, step.level, row, quadrant)];
    }
    return beyond_threshold(tree, row, failing);
}

// Cells that fail in the near quadrants of the tiles around a tile: a coarser tree on this side of the border would show.
fn failing_beside(tile: u32, row: u32) -> u32 {
    let across = i32(tiles_across());
    let at = vec2i(i32(tile) % across, i32(tile) / across);
    var failing = 0u;
    for (var i = 0u; i < 8u; i++) {
        let there = at + neighbour(i);
        if any(there < vec2i(0)) || there.x >= across || there.y >= i32(tile_count()) / across {
            continue;
        }
        for (var quadrant = 0u; quadrant < QUADRANTS; quadrant++) {
            let side = vec2i(vec2u(quadrant % 2u, quadrant / 2u)) * 2 - 1;  // where in its tile the quadrant lies
            let is_near = all((neighbour(i) == vec2i(0)) | (neighbour(i) == -side));
            if is_near {
                let tile_there = u32(there.y * across + there.x);
                failing |= beyond_threshold(tile_there, row, failures[failure_index(tile_there, step.level, row, quadrant)]);
            }
        }
    }
    return failing;
}

// Cells of a row in which some of the tile's probes saw something, and others nothing.
fn cells_of_two_minds(tile: u32, row: u32) -> u32 {
    let width = spacing(step.level);
    let height = select(1u, width, shape.has_rows == 1u);
    var hidden = 0u;
    var lit = 0u;
    for (var deepest = row * height; deepest < (row + 1u) * height; deepest++) {
        hidden |= probes[probe_index(tile, 0u, deepest)];
        lit |= probes[probe_index(tile, 1u, deepest)];
    }
    // Gather each cell's bits at its first.
    for (var i = 1u; i < width; i *= 2u) {
        hidden |= hidden >> i;
        lit |= lit >> i;
    }
    return hidden & lit;
}

// [Schwaerzler2012 §3.3.4] The new corners of the four quarters of each refined cell.
fn request_children(tree: u32, row: u32, cells: u32) {
    let half = spacing(step.level + 1u);
    let in_row = cells | (cells << half) | (cells << (2u * half));
    for (var i = 0u; i < select(1u, 3u, shape.has_rows == 1u); i++) {
        let sample_row = sample_rows(step.level, row).x + i * half;
        trees[request_index(tree, sample_row)] |= in_row;
        atomicOr(&control.needed[sample_row], in_row);
    }
}

// One invocation per tile; the first one writes where all share a tree.
@compute @workgroup_size(INVOCATIONS)
fn cs_refine(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= atomicLoad(&control.levels[step.level].active_tiles) {
        return;
    }
    let tile = control.tile_lists[step.level * tile_count() + id.x];
    let tree = tree_of(tile);
    var is_active = false;
    for (var row = 0u; row < cell_rows(step.level); row++) {
        var cells = failing_cells(tree, row);
        if step.level < shape.sure_levels {
            cells |= failing_beside(tile, row);
        }
        if shape.has_probes == 1u && step.level < shape.deepest {
            cells |= cells_of_two_minds(tile, row);
        }
        // Four corners alone overlook what hides the light's middle: a tile of its own starts with nine samples.
        if step.level == 0u && shape.is_global == 0u {
            cells = 1u;
        }
        cells &= present_cells(tree, row);
        if cells == 0u {
            continue;
        }
        is_active = true;
        if shape.is_global == 0u || id.x == 0u {
            trees[refined_index(tree, step.level, row)] = cells;
            request_children(tree, row, cells);
        }
    }
    if is_active {
        let list_at = atomicAdd(&control.levels[step.level + 1u].active_tiles, 1u);
        control.tile_lists[(step.level + 1u) * tile_count() + list_at] = tile;
    }
}
