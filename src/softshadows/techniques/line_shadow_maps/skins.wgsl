// Depth discontinuities of every map, as the skins that join occluder and receiver across them. [Heidrich2000 §3.2]

//#include "visibility/line_maps/line_map.wgsl"
//#include "control.wgsl"
//#struct Skin
//#struct LineState

@group(1) @binding(0) var<storage, read_write> control: Control;
@group(1) @binding(1) var<storage, read> state: LineState;
@group(1) @binding(2) var<storage, read_write> draws: array<atomic<u32>>;     // arguments: emptied tiles, skins
@group(1) @binding(3) var<storage, read_write> skins: array<Skin>;
@group(1) @binding(4) var<storage, read_write> search: vec3u;                 // arguments of the dispatch of cs_find
@group(1) @binding(5) var<storage, read_write> report: array<u32>;

@group(1) @binding(6) var<storage, read_write> nearest_in_row: array<f32>;  // inverse depth, by sample and number of the row

override capacity: u32;         // of skins
override threshold_texels: f32;

const LANES = 32u;              // that share a row of texels
const CLEAR = 0u;               // where in the draws' arguments
const DRAW = 4u;
const INSTANCES = 1u;           // of a draw's words
const MAPS = 1u;                // words of the report
const SKINS = 2u;
const DROPPED = 3u;

var<workgroup> nearest_of_lanes: array<f32, LANES>;

// Channels are built again where a map or the set of samples is another one than in the frame before.
@compute @workgroup_size(1)
fn cs_prepare() {
    let is_kept = state.drawn_now == 0u && control.samples == control.had_samples;
    control.had_samples = control.samples;
    control.is_kept = select(0u, 1u, is_kept);
    search = select(vec3u(1u, row_count(0u), light_samples.count), vec3u(0u), is_kept);
    atomicStore(&draws[CLEAR], 6u);
    atomicStore(&draws[CLEAR + INSTANCES], select(light_samples.count, 0u, is_kept));
    atomicStore(&draws[DRAW], 6u);
    atomicStore(&draws[DRAW + INSTANCES], 0u);
    if !is_kept {
        control.skins = 0u;
    }
}

fn clamped_texel(view: u32, texel: vec2i) -> vec2u {
    return vec2u(clamp(texel, vec2i(0), vec2i(shadow_views[view].size) - 1));
}

fn inverse_depth_at(view: u32, column: i32, row: i32) -> f32 {
    return map_inverse_depth(view, clamped_texel(view, vec2i(column, row)));
}

// [Heidrich2000 §4] 3×3 Laplacian of Gaussian. Inverse depth is affine on a plane, so this is zero on planes at any slope:
// negative on the near side of a jump, positive on its far side, and of one sign alone along a crease.
fn laplacian(view: u32, column: i32, row: i32) -> f32 {
    var sum = -9.0 * inverse_depth_at(view, column, row);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            sum += inverse_depth_at(view, column + x, row + y);
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
    let occluder = carried_on(near, inverse_depth_at(view, near_column + step, row), jump);
    let receiver = select(0.0, max(carried_on(far, inverse_depth_at(view, near_column - 2 * step, row), jump), 0.0), far > 0.0);
    let index = atomicAdd(&draws[DRAW + INSTANCES], 1u);
    if index < capacity {
        let texel = u32(column) | (u32(row) << 16u);
        skins[index] = Skin(texel, (view % FACES) | (sample << 8u) | (neighbour << 16u), occluder, receiver);
    }
}

// Skins between columns `first` and `end` of a row; returns the nearest inverse depth on the way.
fn find_between(sample: u32, view: u32, row: i32, first: i32, end: i32) -> f32 {
    let texels = threshold_texels / shadow_views[view].texels_per_unit.x;
    var here = inverse_depth_at(view, first, row);
    var nearest = here;
    for (var column = first; column < end; column++) {
        let next = inverse_depth_at(view, column + 1, row);
        let near = max(here, next);
        let least = inverse_depth_of_extent(near, texels);
        if abs(next - here) > least {
            let near_is_right = next > here;
            let near_column = column + select(0, 1, near_is_right);
            let far_column = column + select(1, 0, near_is_right);
            if laplacian(view, near_column, row) < -least && laplacian(view, far_column, row) > least {
                add_skin(sample, view, column, row, near_is_right, near, min(here, next));
            }
        }
        nearest = max(nearest, next);
        here = next;
    }
    return nearest;
}

@compute @workgroup_size(LANES)
fn cs_find(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let sample = group.z;
    nearest_of_lanes[lane] = 0.0;
    // A sample that is not in use still has the map of the last frame that used it.
    if extractBits(control.samples, sample, 1u) == 1u && group.y < row_count(sample) {
        let found = map_row(sample, group.y);
        let last = shadow_views[found.view].size.x - 1u;
        let run = (last + LANES - 1u) / LANES;
        let first = min(lane * run, last);
        let end = min(first + run, last);
        nearest_of_lanes[lane] = find_between(sample, found.view, i32(found.row), i32(first), i32(end));
    }
    for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            nearest_of_lanes[lane] = max(nearest_of_lanes[lane], nearest_of_lanes[lane + stride]);
        }
    }
    if lane == 0u {
        nearest_in_row[first_row(sample) + group.y] = nearest_of_lanes[0];
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
