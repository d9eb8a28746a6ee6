// The receivers: bind group 0 of every pass that finds visibility at the camera's pixels.

//#include "frame.wgsl"

@group(0) @binding(1) var g_position: texture_2d<f32>;  // xyz world, w = linear view depth, 0 = no surface
@group(0) @binding(2) var g_normal: texture_2d<f32>;    // geometric normal facing the viewer, w = triangle

struct Receiver {
    is_surface: bool,
    position_ws: vec3f,
    view_depth: f32,
    normal_ws: vec3f,
    triangle: f32,  // its number, exact up to 2^24
};

fn load_receiver(pixel: vec2u) -> Receiver {
    let position = textureLoad(g_position, pixel, 0);
    let normal = textureLoad(g_normal, pixel, 0);
    return Receiver(position.w > 0.0, position.xyz, position.w, normal.xyz, normal.w);
}
