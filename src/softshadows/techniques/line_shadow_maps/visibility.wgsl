// The visible share of the light at every pixel: hard tests in all maps, weighed by their channels. [Heidrich2000 §3]

//#include "visibility/line_maps/line_map.wgsl"
//#include "visibility/line_maps/ends.wgsl"
//#include "passes/gbuffer/pixel.wgsl"
//#include "control.wgsl"
//#include "gaps.wgsl"

@group(1) @binding(0) var<storage, read> control: Control;
@group(1) @binding(1) var channels: texture_2d<f32>;
@group(1) @binding(2) var<storage, read_write> report: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read> nearest_in_row: array<f32>;  // inverse depth, by sample and number of the row
@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;

override both_ends_see_all: bool = false;
override looks_for_gaps: bool = true;

const UNTOUCHED = 2.0;       // a channel without a skin, which stands for HALF
const HALF = 0.5;
const OVERFULL = 1.01;       // a sum of both channels that the clamp takes more than rounding from
const CLAMPED = 0u;          // words of the report

// What a sample knows: whether it is seen, and the shares of the segments before and after it that are seen from its side.
struct Seen {
    map_sample: MapSample,
    is_lit: bool,
    before: f32,
    after: f32,
};

fn look(sample: u32, receiver: Receiver) -> Seen {
    let map_sample = line_map_sample(sample, receiver);
    if !map_sample_is_lit(map_sample) {
        return Seen(map_sample, false, 0.0, 0.0);
    }
    if !is_rectified(map_sample) {
        return Seen(map_sample, true, UNTOUCHED, UNTOUCHED);
    }
    let found = textureLoad(channels, shadow_views[map_sample.view].origin + covering_texel(map_sample), 0).rg;
    return Seen(map_sample, true, found.x, found.y);
}

// The nearest inverse depth in the row of the sample's map that the map sample goes through.
fn nearest_beside(sample: u32, map_sample: MapSample) -> f32 {
    return nearest_in_row[first_row(sample) + row_number(map_sample.view, covering_texel(map_sample).y)];
}

// The shares of the segment between two neighbouring samples that count for one and for the other; their sum is visible.
fn segment_shares(sample: u32, next: u32, start: Seen, end: Seen) -> vec2f {
    let shares = vec2f(start.after, end.before);
    let are_untouched = shares == vec2f(UNTOUCHED);
    if all(are_untouched) || (both_ends_see_all && start.is_lit && end.is_lit) {
        return vec2f(HALF);
    }
    if !looks_for_gaps || !is_rectified(start.map_sample) || !is_rectified(end.map_sample) {
        return select(shares, vec2f(HALF), are_untouched);
    }
    let length = light_samples.points[next].x - light_samples.points[sample].x;
    let nearest = vec2f(nearest_beside(sample, start.map_sample), nearest_beside(next, end.map_sample));
    let known = select(shares, vec2f(0.0), are_untouched);
    let unknown_weight = select(0.0, HALF, any(are_untouched));
    return known + HALF * share_between(start.map_sample, end.map_sample, length, known, nearest, unknown_weight);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    let receiver = begin_pixel(id.xy);
    if !receiver.is_surface {
        return;
    }
    if light_samples.count == 1u {
        visibility[receiver.index] = select(0.0, 1.0, map_sample_is_lit(line_map_sample(0u, receiver)));
        return;
    }
    // [Heidrich2000 §3.3] Segments between neighbouring samples are lights of their own.
    var shading: Shading;
    var is_overfull = false;
    var sample = 0u;
    var start = look(0u, receiver);
    while sample + 1u < light_samples.count {
        let next = sample_after(control.samples, sample);
        let end = look(next, receiver);
        let shares = segment_shares(sample, next, start, end);
        let share = shares.x + shares.y;
        is_overfull |= share > OVERFULL;
        shading = with_segment(shading, sample, next, receiver, shares / max(share, 1.0), vec2f(HALF));
        sample = next;
        start = end;
    }
    visibility[receiver.index] = visibility_of(shading);
    if is_overfull {
        atomicAdd(&report[CLAMPED], 1u);
    }
}
