// One shadow map per pass: the occluders of one view, over the whole layer.

//#include "../src/softshadows/passes/shadow_atlas/occluder.wgsl"

@vertex
fn vs_layer(@location(0) position_ws: vec3f, view: View) -> @builtin(position) vec4f {
    return project(position_ws, view).position_cs;
}
