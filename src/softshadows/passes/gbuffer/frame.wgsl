// The camera and the image: bind group 0, binding 0 of every pass that looks through the camera.

//#struct FrameUniforms

@group(0) @binding(0) var<uniform> frame: FrameUniforms;

// Direction through a point of the image in pixels (centres at + 0.5, row 0 at the top); one metre deep, world space.
fn camera_ray_ws(pixel: vec2f) -> vec3f {
    let ndc = 2.0 * pixel / vec2f(frame.size) - 1.0;
    return frame.camera_right_ws * (ndc.x * frame.tan_half_width) - frame.camera_up_ws * (ndc.y * frame.tan_half_height)
        - frame.camera_back_ws;
}
