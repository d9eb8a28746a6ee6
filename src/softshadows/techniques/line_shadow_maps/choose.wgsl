// Where two segments are too few: samples inserted where hard tests of three neighbouring samples contradict each other.
//
// A pixel that sees both outer samples but not the middle one, or the middle one but neither outer, tells that the outer
// two do not know what lies between them. Where too many pixels say so, both halves get a sample in their middle.

//#include "receiver.wgsl"
//#include "../../passes/line_maps/line_map.wgsl"
//#include "control.wgsl"
//#struct Halving

@group(1) @binding(0) var<storage, read_write> control: Control;
@group(1) @binding(1) var<storage, read_write> contradictions: array<atomic<u32>>;  // by pair of segments; the last: pixels tested
@group(1) @binding(2) var<storage, read_write> requests: array<u32>;
@group(1) @binding(3) var<uniform> halving: Halving;

override tolerance: f32;  // of the pixels tested

const PIXEL_STEP = 2u;    // of the picture, every second pixel along each side is asked
const TESTED = 31u;

@compute @workgroup_size(1)
fn cs_begin() {
    control.samples = requests[0];
}

fn is_seen(sample: u32, receiver: LightReceiver) -> bool {
    return sight_is_lit(line_sight(sample, receiver));
}

@compute @workgroup_size(8, 8)
fn cs_test(@builtin(global_invocation_id) id: vec3u) {
    let pixel = PIXEL_STEP * id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let surface = load_receiver(pixel);
    if !surface.is_surface {
        return;
    }
    atomicAdd(&contradictions[TESTED], 1u);
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    let step = halving.half_spacing;
    for (var middle = step; middle < light.sample_count; middle += 2u * step) {
        if ((control.samples >> middle) & 1u) == 0u {
            continue;
        }
        let before = is_seen(middle - step, receiver);
        if before == is_seen(middle + step, receiver) && before != is_seen(middle, receiver) {
            atomicAdd(&contradictions[middle / (2u * step)], 1u);
        }
    }
}

@compute @workgroup_size(1)
fn cs_choose() {
    let step = halving.half_spacing;
    let tolerated = tolerance * f32(atomicLoad(&contradictions[TESTED]));
    var requested = 0u;
    for (var middle = step; middle < light.sample_count; middle += 2u * step) {
        if f32(atomicLoad(&contradictions[middle / (2u * step)])) > tolerated {
            requested |= (1u << (middle - step / 2u)) | (1u << (middle + step / 2u));
        }
    }
    requests[halving.stage] = requested;
    control.samples |= requested;
}
