// A point of a surface that receives light: in world space and, once `seen_by` a light, in that light's space.

//#include "light.wgsl"

struct Receiver {
    is_surface: bool,     // false where there is none, and then nothing else is known
    index: u32,           // of its visibility by the light that it is seen by
    position_ws: vec3f,
    view_depth: f32,
    normal_ws: vec3f,     // geometric, faces the viewer
    triangle: f32,        // its number, exact up to 2^24
    position_ls: vec3f,
    normal_ls: vec3f,
};

fn seen_by(light: Light, receiver: Receiver) -> Receiver {
    var seen = receiver;
    seen.position_ls = to_light_space(light, receiver.position_ws - light.center_ws);
    seen.normal_ls = to_light_space(light, receiver.normal_ws);
    return seen;
}
