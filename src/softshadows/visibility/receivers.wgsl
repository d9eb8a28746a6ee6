// Boxes around the receivers: for every 8×8 pixels, the extent in light space of the surfaces that something can shadow.

//#include "passes/gbuffer/receiver.wgsl"
//#include "swept_box.wgsl"
//#struct ReceiverBox
//#struct OccluderBox

@group(2) @binding(0) var<storage, read> light: Light;
@group(2) @binding(1) var<storage, read_write> receiver_boxes: array<ReceiverBox>;
@group(2) @binding(2) var<storage, read> occluder_boxes: array<OccluderBox>;

const EDGE = 8u;
const LANES = 64u;

var<workgroup> lows_ls: array<vec3f, LANES>;
var<workgroup> highs_ls: array<vec3f, LANES>;
var<workgroup> lows_ws: array<vec3f, LANES>;
var<workgroup> highs_ws: array<vec3f, LANES>;
var<workgroup> footprints: array<vec2f, LANES>;  // sum of pixel widths in metres, number of receivers
var<workgroup> shadowed: atomic<u32>;

// Some part of the light lies before the receiver's plane, and the receiver before a one-sided light.
fn can_be_lit(receiver: Receiver) -> bool {
    if light.is_directional == 1u {
        return receiver.normal_ls.z > 0.0;
    }
    return heights_of(light, receiver).y > 0.0 && is_on_emitting_side(light, receiver);
}

@compute @workgroup_size(EDGE, EDGE)
fn cs_bound_receivers(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    if lane == 0u {
        atomicStore(&shadowed, 0u);  // wgpu does not clear workgroup memory, though WebGPU says so
    }
    lows_ls[lane] = vec3f(3e38);
    highs_ls[lane] = vec3f(-3e38);
    lows_ws[lane] = vec3f(3e38);
    highs_ws[lane] = vec3f(-3e38);
    footprints[lane] = vec2f(0.0);
    if all(id.xy < frame.size) {
        let receiver = seen_by(light, load_receiver(id.xy));
        if receiver.is_surface && can_be_lit(receiver) {
            lows_ls[lane] = receiver.position_ls;
            highs_ls[lane] = receiver.position_ls;
            lows_ws[lane] = receiver.position_ws;
            highs_ws[lane] = receiver.position_ws;
            footprints[lane] = vec2f(receiver.view_depth * frame.pixel_extent, 1.0);
        }
    }
    for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lows_ls[lane] = min(lows_ls[lane], lows_ls[lane + stride]);
            highs_ls[lane] = max(highs_ls[lane], highs_ls[lane + stride]);
            lows_ws[lane] = min(lows_ws[lane], lows_ws[lane + stride]);
            highs_ws[lane] = max(highs_ws[lane], highs_ws[lane + stride]);
            footprints[lane] += footprints[lane + stride];
        }
    }
    workgroupBarrier();

    // Drop receivers that no occluder's box can shadow.
    let reach = abs(light.right_ws) * light.half_width + abs(light.up_ws) * light.half_height;
    var light_low = light.center_ws - reach;
    var light_high = light.center_ws + reach;
    if light.is_directional == 1u {
        light_low = lows_ws[0] + light.back_ws * (2.0 * max(frame.scene_diagonal, 1e-6));
        light_high = highs_ws[0] + light.back_ws * (2.0 * max(frame.scene_diagonal, 1e-6));
    }
    if footprints[0].y > 0.0 {
        for (var i = lane; i < arrayLength(&occluder_boxes); i += LANES) {
            let box = occluder_boxes[i];
            if can_shadow(box.low_ws, box.high_ws, lows_ws[0], highs_ws[0], light_low, light_high) {
                atomicStore(&shadowed, 1u);
                break;
            }
        }
    }
    workgroupBarrier();
    if lane == 0u {
        let pixels = footprints[0].y;
        let count = select(0.0, pixels, atomicLoad(&shadowed) == 1u);
        let index = group.y * groups.x + group.x;
        receiver_boxes[index] = ReceiverBox(lows_ls[0], count, highs_ls[0], footprints[0].x / max(pixels, 1.0));
    }
}
