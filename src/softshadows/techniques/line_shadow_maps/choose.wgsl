// Where two samples know too little of what lies between them: samples inserted where the one in their middle contradicts them.
//
// What both outer samples see, the middle one should see, unless the rows of the outer maps show a shadow there. What neither
// sees, it should see only where the rows show a gap. Where too many pixels say otherwise, both halves get a sample in their
// middle.

//#include "passes/gbuffer/receiver.wgsl"
//#include "visibility/line_maps/line_map.wgsl"
//#include "control.wgsl"
//#include "gaps.wgsl"
//#struct Halving

@group(1) @binding(0) var<storage, read_write> control: Control;
@group(1) @binding(1) var<storage, read_write> contradictions: array<atomic<u32>>;  // by pair of segments; the last: pixels tested
@group(1) @binding(2) var<storage, read_write> requests: array<u32>;
@group(1) @binding(3) var<storage, read> halving: Halving;

override tolerance: f32;      // of the pixels tested
override knows_rows: bool;    // visibility takes what the rows show into account

const PIXEL_STEP = 4u;    // of the picture, every fourth pixel along each side is asked
const TESTED = 31u;
const NEAREST = 1e9;         // inverse depth: the rows are followed to their ends
const MIDDLE_BINS = 3u << (BINS / 2u - 1u);

@compute @workgroup_size(1)
fn cs_begin() {
    control.samples = requests[0];
}

// Do the rows of the outer maps show that the middle is hidden from the receiver? 1 yes, 0 no, 0.5 at its border.
fn hidden_in_rows(start: MapSample, end: MapSample, length: f32) -> f32 {
    let hidden = hidden_bins(start, length, 1.0, NEAREST).bins | reverseBits(hidden_bins(end, length, -1.0, NEAREST).bins);
    return 0.5 * f32(countOneBits(hidden & MIDDLE_BINS));
}

// Do the outer samples know otherwise of the middle than it sees itself?
fn is_contradicted(middle: u32, step: u32, receiver: Receiver) -> bool {
    let start = line_map_sample(middle - step, receiver);
    let end = line_map_sample(middle + step, receiver);
    let outer_are_seen = map_sample_is_lit(start);
    if outer_are_seen != map_sample_is_lit(end) {
        return false;
    }
    let middle_is_seen = map_sample_is_lit(line_map_sample(middle, receiver));
    if outer_are_seen && middle_is_seen {
        return false;
    }
    if !knows_rows || !is_rectified(start) || !is_rectified(end) {
        return outer_are_seen != middle_is_seen;
    }
    let length = light_samples.points[middle + step].x - light_samples.points[middle - step].x;
    return hidden_in_rows(start, end, length) == select(0.0, 1.0, middle_is_seen);
}

@compute @workgroup_size(8, 8)
fn cs_test(@builtin(global_invocation_id) id: vec3u) {
    let pixel = PIXEL_STEP * id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let receiver = seen_by(light, load_receiver(pixel));
    if !receiver.is_surface {
        return;
    }
    atomicAdd(&contradictions[TESTED], 1u);
    let step = halving.half_spacing;
    for (var middle = step; middle < light_samples.count; middle += 2u * step) {
        if ((control.samples >> middle) & 1u) == 0u {
            continue;
        }
        if is_contradicted(middle, step, receiver) {
            atomicAdd(&contradictions[middle / (2u * step)], 1u);
        }
    }
}

@compute @workgroup_size(1)
fn cs_choose() {
    let step = halving.half_spacing;
    let tolerated = tolerance * f32(atomicLoad(&contradictions[TESTED]));
    var requested = 0u;
    for (var middle = step; middle < light_samples.count; middle += 2u * step) {
        if f32(atomicLoad(&contradictions[middle / (2u * step)])) > tolerated {
            requested |= (1u << (middle - step / 2u)) | (1u << (middle + step / 2u));
        }
    }
    requests[halving.stage] = requested;
    control.samples |= requested;
}
