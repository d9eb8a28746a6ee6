// Boxes around the receivers: for every 8×8 pixels, the extent of their surfaces in light space.

//#include "receiver.wgsl"
//#include "light_space.wgsl"
//#struct ReceiverBox

@group(2) @binding(0) var<uniform> light: ShadowLight;
@group(2) @binding(1) var<storage, read_write> receiver_boxes: array<ReceiverBox>;

const EDGE = 8u;

var<workgroup> lows: array<vec3f, 64>;
var<workgroup> highs: array<vec3f, 64>;
var<workgroup> footprints: array<vec2f, 64>;  // sum of pixel footprints in metres, number of receivers

// Some part of the light lies before the receiver's plane, and the receiver before a one-sided light.
fn can_be_lit(point_ls: vec3f, normal_ls: vec3f) -> bool {
    if light.is_directional == 1u {
        return normal_ls.z > 0.0;
    }
    let center_height = -dot(normal_ls, point_ls);
    let highest = center_height + abs(normal_ls.x) * light.half_width + abs(normal_ls.y) * light.half_height;
    return highest > 0.0 && (light.is_one_sided == 0u || point_ls.z < 0.0);
}

@compute @workgroup_size(EDGE, EDGE)
fn cs_bound_receivers(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    lows[lane] = vec3f(3e38);
    highs[lane] = vec3f(-3e38);
    footprints[lane] = vec2f(0.0);
    if all(id.xy < frame.size) {
        let receiver = load_receiver(id.xy);
        let point = to_light_space(light, receiver.position_ws - light.center_ws);
        if receiver.is_surface && can_be_lit(point, to_light_space(light, receiver.normal_ws)) {
            lows[lane] = point;
            highs[lane] = point;
            footprints[lane] = vec2f(receiver.view_depth * frame.pixel_extent, 1.0);
        }
    }
    for (var stride = 32u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lows[lane] = min(lows[lane], lows[lane + stride]);
            highs[lane] = max(highs[lane], highs[lane + stride]);
            footprints[lane] += footprints[lane + stride];
        }
    }
    if lane == 0u {
        let count = footprints[0].y;
        receiver_boxes[group.y * groups.x + group.x] = ReceiverBox(lows[0], count, highs[0], footprints[0].x / max(count, 1.0));
    }
}
