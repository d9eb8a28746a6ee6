// Find the occluding edges in every row of the maps, and hand each one to the texels in its penumbra.
//
// Seen from the other end of a segment of length s, a point at u, inverse depth w, lies at u - s w. Along a row, points keep that
// order: what comes earlier there than something it follows here is hidden by it, wholly or in part. The edge is the
// outermost thing that was passed, so the paper's steps 2 and 3 are one prefix minimum with its place.
//
// One workgroup walks one row, against u for the segment after the sample and along u for the one before; each lane its cell.

//#include "edge_map.wgsl"

@group(3) @binding(0) var edge_map: texture_storage_2d<r32uint, write>;
@group(3) @binding(1) var<storage, read_write> cells: array<f32>;  // the greatest inverse depth in each cell of every row

override uses_tilt: bool;
override uses_order: bool;

const LANES = CELLS;
const OUT_OF_ROW = 3e38;
const JUMP_TEXELS = 2.0;  // a surface that is seen less steeply than that moves less from texel to texel

// What a lane walks for the segment on one side: its columns, in a row of a view.
struct Cell {
    row: u32,
    first: u32,
    end: u32,
    side: u32,
    reach: f32,  // texels of disparity per inverse depth
};

// A texel's inverse depth, and [Reimann2016 §3.1] where its surface lies in the order seen from the segment's other end: walking
// on, that gets less.
struct Texel {
    inverse_depth: f32,
    place: f32,
};

// The outermost edge passed so far: its place, its column, and whether the map jumps beside it.
struct Passed {
    place: f32,
    entry: u32,
};

var<workgroup> passed_places: array<f32, LANES>;
var<workgroup> passed_entries: array<u32, LANES>;

fn load_texel(view: ShadowView, cell: Cell, column: i32) -> Texel {
    if u32(column) >= view.size.x {  // or before the row, where it wraps around
        return Texel(0.0, OUT_OF_ROW);
    }
    let inverse_depth = textureLoad(shadow_atlas, view.origin + vec2u(u32(column), cell.row), 0) / maps.depth_scale;
    return Texel(inverse_depth, direction(cell.side) * f32(column) - cell.reach * inverse_depth);
}

fn jumps(here: f32, next: f32) -> bool {
    return abs(next - here) > JUMP_TEXELS;
}

// [Reimann2016 §3.2 strategy 1] The surface faces the other sample here and turns away in the next texel. On one surface the
// texels' order says so: where it turns away, it is seen from behind.
fn is_edge_by_tilt(before: f32, here: f32, next: f32) -> bool {
    return before > here && !jumps(before, here) && next > here && !jumps(here, next);
}

// [Reimann2016 §3.2 strategy 2] The next two texels lie out of order.
fn is_edge_by_order(here: f32, next: f32, after: f32) -> bool {
    return next > here && after > here;
}

// What comes of a walk: the edge passed last, the place that comes last of all, and the greatest inverse depth.
struct Walked {
    passed: Passed,
    last_place: f32,
    nearest: f32,
};

// [Reimann2016 §3.3] Walk the cell, `start` being passed before it. Texels out of order get the edge passed last.
fn walk(view: ShadowView, cell: Cell, start: Passed) -> Walked {
    let step = -i32(direction(cell.side));
    var column = select(i32(cell.end) - 1, i32(cell.first), cell.side == BEFORE);
    var walked = Walked(start, -OUT_OF_ROW, 0.0);
    var before = load_texel(view, cell, column - step).place;
    var here = load_texel(view, cell, column);
    var next = load_texel(view, cell, column + step);
    var word = 0u;
    for (var left = cell.end - cell.first; left > 0u; left--) {
        let after = load_texel(view, cell, column + 2 * step);
        walked.last_place = max(walked.last_place, here.place);
        walked.nearest = max(walked.nearest, here.inverse_depth);
        if here.place > walked.passed.place {
            word |= walked.passed.entry << (16u * (u32(column) % 2u));
        } else if (uses_tilt && is_edge_by_tilt(before, here.place, next.place))
            || (uses_order && is_edge_by_order(here.place, next.place, after.place)) {
            let jump = select(0u, EDGE_JUMPS, jumps(here.place, next.place));
            walked.passed = Passed(here.place, (1u + u32(column)) | jump);
        }
        before = here.place;
        here = next;
        next = after;
        column += step;
        if (u32(column) % 2u == 0u) == (step > 0) || left == 1u {  // a pair of columns, or a row of an odd number, is complete
            let texel = vec2u(u32(column - step), cell.row);
            textureStore(edge_map, entry_word(view, texel, cell.side), vec4u(word, 0u, 0u, 0u));
            word = 0u;
        }
    }
    return walked;
}

// What all the cells that are walked before this lane's have passed: an exclusive scan, in the order of the walk.
fn passed_before(lane: u32, side: u32, alone: Passed) -> Passed {
    let turn = select(LANES - 1u - lane, lane, side == BEFORE);
    var passed = alone;
    for (var stride = 1u; stride < LANES; stride *= 2u) {
        passed_places[turn] = passed.place;
        passed_entries[turn] = passed.entry;
        workgroupBarrier();
        if turn >= stride && passed_places[turn - stride] < passed.place {
            passed = Passed(passed_places[turn - stride], passed_entries[turn - stride]);
        }
        workgroupBarrier();
    }
    passed_places[turn] = passed.place;
    passed_entries[turn] = passed.entry;
    workgroupBarrier();
    if turn == 0u {
        return Passed(OUT_OF_ROW, NO_EDGE);
    }
    return Passed(passed_places[turn - 1u], passed_entries[turn - 1u]);
}

@compute @workgroup_size(LANES)
fn cs_outreach(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = group.x;
    let sample = group.y;
    let found = map_row(sample, number);
    let view = shadow_views[found.view];
    let width = cell_width(found.view);
    let first = min(lane * width, view.size.x);
    for (var side = AFTER; side <= BEFORE; side++) {
        if !has_segment(sample, side) {
            continue;
        }
        let reach = segment_length(sample, side) * view.texels_per_unit.x;
        let cell = Cell(found.row, first, min(first + width, view.size.x), side, reach);
        let alone = walk(view, cell, Passed(OUT_OF_ROW, NO_EDGE));
        cells[first_cell(sample, number) + lane] = alone.nearest;
        let start = passed_before(lane, side, alone.passed);
        if start.place < alone.last_place {
            walk(view, cell, start);
        }
        workgroupBarrier();
    }
}
