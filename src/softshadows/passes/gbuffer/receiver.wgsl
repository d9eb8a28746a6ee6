// The receivers: bind group 0 of every pass that finds visibility at the camera's pixels.

//#include "frame.wgsl"
//#include "lights/receiver.wgsl"

@group(0) @binding(1) var g_position: texture_2d<f32>;  // xyz world, w = linear view depth, 0 = no surface
@group(0) @binding(2) var g_normal: texture_2d<f32>;    // geometric normal facing the viewer, w = triangle

fn load_receiver(pixel: vec2u) -> Receiver {
    let position = textureLoad(g_position, pixel, 0);
    let normal = textureLoad(g_normal, pixel, 0);
    var receiver: Receiver;
    receiver.is_surface = position.w > 0.0;
    receiver.position_ws = position.xyz;
    receiver.view_depth = position.w;
    receiver.normal_ws = normal.xyz;
    receiver.triangle = normal.w;
    return receiver;
}
