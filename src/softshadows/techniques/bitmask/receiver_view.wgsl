// A receiver in light space, where its walk starts.

//#include "passes/gbuffer/receiver.wgsl"
//#include "visibility/rays/tree_node.wgsl"

@group(1) @binding(0) var<storage, read> light: Light;
@group(1) @binding(1) var<storage, read> light_tree: TreeGrid;

const LIFT = 9.5367431640625e-7;  // 16 × 2^-24 of the largest coordinate, as rays (visibility/rays/light_rays.wgsl)

struct LiftedReceiver {
    origin: vec3f,      // off its surface by `lift` metres, so that the surface does not hide the light; from the light's centre
    place: vec3f,       // the same in the tree's space (light_tree_space.wgsl)
    normal: vec3f,
    lift: f32,
    light_lift: f32,    // metres before the light's plane within which nothing hides it
};

fn lift_at(position_ws: vec3f) -> f32 {
    let size = abs(position_ws);
    return LIFT * max(max(size.x, size.y), max(size.z, light_tree.extent));
}

fn lifted(receiver: Receiver) -> LiftedReceiver {
    let lift = lift_at(receiver.position_ws);
    let origin_ws = receiver.position_ws + lift * receiver.normal_ws;
    let origin = to_light_space(light, origin_ws - light.center_ws);
    return LiftedReceiver(origin, to_light_space(light, origin_ws), receiver.normal_ls, lift, lift_at(light.center_ws));
}
