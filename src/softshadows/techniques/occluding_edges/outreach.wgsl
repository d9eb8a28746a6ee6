// Find the occluding edges in every row of the maps, and hand each one to the texels in its penumbra.
//
// Seen from the other end of a segment of length s, a point at u, closeness w, lies at u - s w. Along a row, points keep that
// order: what comes earlier there than something it follows here is hidden by it, wholly or in part. The edge is the
// outermost thing that was passed, so the paper's steps 2 and 3 are one prefix minimum with its place.
//
// One workgroup walks one row, against u for the segment after the sample and along u for the one before; each lane its cell.

//#include "edge_map.wgsl"

@group(3) @binding(0) var edge_map: texture_storage_2d<r32uint, write>;
@group(3) @binding(1) var<storage, read_write> cells: array<f32>;  // the greatest closeness in each cell of every row

override uses_tilt: bool;
override uses_order: bool;

const LANES = CELLS;
const WIDEST_CELL = 256u;  // columns: a row of 16384
const BESIDE = 2u;         // columns that a cell knows of its neighbours
const NO_COLUMN = -1.0;
const OUT_OF_ROW = 3e38;
const JUMP_TEXELS = 2.0;  // a surface that is seen less steeply than that moves less from texel to texel

// What a lane walks: its columns, in a row of a view.
struct Cell {
    view: u32,
    row: u32,
    first: u32,
    end: u32,
};

// The outermost edge passed so far: its place in the order seen from the segment's other end, its column, and whether the map
// jumps beside it.
struct Passed {
    place: f32,
    entry: u32,
};

var<workgroup> passed_places: array<f32, LANES>;
var<workgroup> passed_entries: array<u32, LANES>;

var<private> closeness: array<f32, WIDEST_CELL + 2u * BESIDE>;
var<private> entries: array<u32, WIDEST_CELL>;

// A lane's cell in the row of that number, of all rows of a sample's faces.
fn cell_of(number: u32, sample: u32, lane: u32) -> Cell {
    let found = map_row(sample, number);
    let width = shadow_views[found.view].size.x;
    let first = min(lane * cell_width(found.view), width);
    return Cell(found.view, found.row, first, min(first + cell_width(found.view), width));
}

// Load the cell and what is beside it; returns the greatest closeness in the cell.
fn load_cell(cell: Cell) -> f32 {
    let view = shadow_views[cell.view];
    var greatest = 0.0;
    for (var i = 0u; i < cell.end + 2u * BESIDE - cell.first; i++) {
        let column = cell.first + i - BESIDE;  // wraps around before the row, and so lies beyond it
        closeness[i] = NO_COLUMN;
        if column < view.size.x {
            closeness[i] = textureLoad(shadow_atlas, view.origin + vec2u(column, cell.row), 0) / light.depth_scale;
            greatest = max(greatest, closeness[i]);
        }
    }
    return greatest;
}

// [Reimann2016 §3.1] Where a texel's surface lies in the order seen from the other end, `reach` texels of disparity
// per closeness away: walking on, against `forth` along u, it gets less.
fn place(i: u32, forth: f32, reach: f32) -> f32 {
    if closeness[i] == NO_COLUMN {
        return OUT_OF_ROW;
    }
    return forth * f32(i) - reach * closeness[i];
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

// What comes of a walk: the edge passed last, and the place that comes last of all.
struct Walked {
    passed: Passed,
    last_place: f32,
};

// [Reimann2016 §3.3] Walk the cell for the segment on this side, `start` being passed before it. Texels out of order get the
// edge passed last, in their half of `entries`.
fn walk(cell: Cell, side: u32, start: Passed) -> Walked {
    let forth = direction(side);
    let reach = segment_length(cell.view / FACES, side) * shadow_views[cell.view].texels_per_unit.x;
    let offset = forth * f32(cell.first);  // of the cell's places in the row's
    let count = cell.end - cell.first;
    let step = select(-1, 1, side == BEFORE);
    var i = select(i32(count + BESIDE) - 1, i32(BESIDE), side == BEFORE);
    var passed = Passed(start.place - offset, start.entry);
    var last_place = -OUT_OF_ROW;
    var before = place(u32(i - step), forth, reach);
    var here = place(u32(i), forth, reach);
    var next = place(u32(i + step), forth, reach);
    for (var walked = 0u; walked < count; walked++) {
        let after = place(u32(i + 2 * step), forth, reach);
        let in_cell = u32(i) - BESIDE;
        last_place = max(last_place, here);
        if here > passed.place {
            entries[in_cell] = insertBits(entries[in_cell], passed.entry, select(0u, 16u, side == BEFORE), 16u);
        } else if (uses_tilt && is_edge_by_tilt(before, here, next)) || (uses_order && is_edge_by_order(here, next, after)) {
            passed = Passed(here, (1u + cell.first + in_cell) | select(0u, EDGE_JUMPS, jumps(here, next)));
        }
        before = here;
        here = next;
        next = after;
        i += step;
    }
    return Walked(Passed(passed.place + offset, passed.entry), last_place + offset);
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
    let cell = cell_of(group.x, group.y, lane);
    cells[first_cell(group.y, group.x) + lane] = load_cell(cell);
    for (var side = AFTER; side <= BEFORE; side++) {
        if !has_segment(group.y, side) {
            continue;
        }
        let alone = walk(cell, side, Passed(OUT_OF_ROW, NO_EDGE));
        let start = passed_before(lane, side, alone.passed);
        if start.place < alone.last_place {
            walk(cell, side, start);
        }
        workgroupBarrier();
    }
    for (var in_cell = 0u; in_cell < cell.end - cell.first; in_cell++) {
        let texel = shadow_views[cell.view].origin + vec2u(cell.first + in_cell, cell.row);
        textureStore(edge_map, texel, vec4u(entries[in_cell], 0u, 0u, 0u));
    }
}
