// Depth discontinuities of every map, as the skins that join occluder and receiver across them. [Heidrich2000 §3.2]

//#include "../../passes/line_maps/line_map.wgsl"
//#include "control.wgsl"
//#struct Skin
//#struct LineState

@group(1) @binding(0) var<storage, read_write> control: Control;
@group(1) @binding(1) var<storage, read> state: LineState;
@group(1) @binding(2) var<storage, read_write> draws: array<atomic<u32>>;     // arguments: emptied tiles, skins
@group(1) @binding(3) var<storage, read_write> skins: array<Skin>;
@group(1) @binding(4) var<storage, read_write> search: vec3u;                 // arguments of the dispatch of cs_find
@group(1) @binding(5) var<storage, read_write> report: array<u32>;

override capacity: u32;         // of skins
override threshold_texels: f32;

const RUN = 16u;                // texels of a row that an invocation walks along
const ROWS = 16u;               // of a workgroup
const RUNS = 4u;
const CLEAR = 0u;               // where in the draws' arguments
const DRAW = 4u;
const INSTANCES = 1u;           // of a draw's words
const MAPS = 1u;                // words of the report
const SKINS = 2u;
const DROPPED = 3u;

// Channels are built again where a map or the set of samples is another one than in the frame before.
@compute @workgroup_size(1)
fn cs_prepare() {
    let is_kept = state.drawn_now == 0u && control.samples == control.had_samples;
    control.had_samples = control.samples;
    control.is_kept = select(0u, 1u, is_kept);
    let runs = (light.tile_size + RUN * RUNS - 1u) / (RUN * RUNS);
    let rows = (light.tile_size + ROWS - 1u) / ROWS;
    search = select(vec3u(runs, rows, light.sample_count), vec3u(0u), is_kept);
    atomicStore(&draws[CLEAR], 6u);
    atomicStore(&draws[CLEAR + INSTANCES], select(light.sample_count, 0u, is_kept));
    atomicStore(&draws[DRAW], 6u);
    atomicStore(&draws[DRAW + INSTANCES], 0u);
    if !is_kept {
        control.skins = 0u;
    }
}

fn clamped_texel(view: u32, texel: vec2i) -> vec2u {
    return vec2u(clamp(texel, vec2i(0), vec2i(shadow_views[view].size) - 1));
}

fn closeness_at(view: u32, column: i32, row: i32) -> f32 {
    return map_closeness(view, clamped_texel(view, vec2i(column, row)));
}

// [Heidrich2000 §4] 3×3 Laplacian of Gaussian. Closeness is affine on a plane, so this is zero on planes at any slope:
// negative on the near side of a jump, positive on its far side, and of one sign alone along a crease.
fn laplacian(view: u32, column: i32, row: i32) -> f32 {
    var sum = -9.0 * closeness_at(view, column, row);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            sum += closeness_at(view, column + x, row + y);
        }
    }
    return sum;
}

// Half a texel on, towards the jump, along the surface: where it is smooth beside a jump of this size.
fn carried_on(here: f32, behind: f32, jump: f32) -> f32 {
    let slope = here - behind;
    return here + select(0.0, 0.5 * slope, abs(slope) < 0.5 * jump);
}

// A skin goes into the map of the next sample on the side that looks behind the occluder's edge.
fn add_skin(sample: u32, view: u32, column: i32, row: i32, near_is_right: bool, near: f32, far: f32) {
    let neighbour = select(sample_after(control.samples, sample), sample_before(control.samples, sample), near_is_right);
    if neighbour == sample {
        return;
    }
    let step = select(-1, 1, near_is_right);
    let near_column = column + select(0, 1, near_is_right);
    let jump = near - far;
    let occluder = carried_on(near, closeness_at(view, near_column + step, row), jump);
    let receiver = select(0.0, max(carried_on(far, closeness_at(view, near_column - 2 * step, row), jump), 0.0), far > 0.0);
    let index = atomicAdd(&draws[DRAW + INSTANCES], 1u);
    if index < capacity {
        let texel = u32(column) | (u32(row) << 16u);
        skins[index] = Skin(texel, (view % FACES) | (sample << 8u) | (neighbour << 16u), occluder, receiver);
    }
}

@compute @workgroup_size(RUNS, ROWS)
fn cs_find(@builtin(global_invocation_id) id: vec3u) {
    let sample = id.z;
    if ((control.samples >> sample) & 1u) == 0u {
        return;
    }
    // The face whose band of the tile holds this row.
    let tile_row = (sample / light.tiles_per_row) * light.tile_size + id.y;
    var view = 0u;
    var row = 0i;
    for (var face = 0u; face < LINE_FACES; face++) {
        let band = shadow_views[sample * FACES + face];
        if tile_row >= band.origin.y && tile_row < band.origin.y + band.size.y {
            view = sample * FACES + face;
            row = i32(tile_row - band.origin.y);
            break;
        }
        if face + 1u == LINE_FACES {
            return;
        }
    }

    let first = i32(id.x * RUN);
    let end = min(first + i32(RUN), i32(shadow_views[view].size.x) - 1);
    let texels = threshold_texels / shadow_views[view].texels_per_unit.x;
    if first >= end {
        return;
    }
    var here = closeness_at(view, first, row);
    for (var column = first; column < end; column++) {
        let next = closeness_at(view, column + 1, row);
        let near = max(here, next);
        let least = closeness_of_extent(light, near, texels);
        if abs(next - here) > least {
            let near_is_right = next > here;
            let near_column = column + select(0, 1, near_is_right);
            let far_column = column + select(1, 0, near_is_right);
            if laplacian(view, near_column, row) < -least && laplacian(view, far_column, row) > least {
                add_skin(sample, view, column, row, near_is_right, near, min(here, next));
            }
        }
        here = next;
    }
}

// Draw as many skins as the list holds, and count.
@compute @workgroup_size(1)
fn cs_finish() {
    if control.is_kept == 0u {
        control.skins = atomicLoad(&draws[DRAW + INSTANCES]);
        atomicStore(&draws[DRAW + INSTANCES], min(control.skins, capacity));
    }
    report[MAPS] += countOneBits(control.samples);
    report[SKINS] += control.skins;
    report[DROPPED] += max(control.skins, capacity) - capacity;
}
