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

// False behind a one-sided light.
fn is_on_emitting_side(light: Light, receiver: Receiver) -> bool {
    return light.is_one_sided == 0u || receiver.position_ls.z < 0.0;
}

// The lowest and the highest that the light reaches above the receiver's plane; of a round light, its square's corners.
fn heights_of(light: Light, receiver: Receiver) -> vec2f {
    let center = -dot(receiver.normal_ls, receiver.position_ls);
    let reach = abs(receiver.normal_ls.x) * light.half_width + abs(receiver.normal_ls.y) * light.half_height;
    return vec2f(center - reach, center + reach);
}
