// Rays from a receiver to points on the light, gathered four at a time: "is light sample s visible from p?", answered exactly.
// They start and end as the truth's do (truth/tracer.py, OFFSET).

//#include "visibility/query.wgsl"
//#include "lights/light_samples.wgsl"
//#include "occluded.wgsl"

const OFFSET = 9.5367431640625e-7;  // 16 × 2^-24 of the largest coordinate: a start that no triangle blocks by rounding

// Where the rays from a receiver start, and how far they go.
struct RayStart {
    origin_ws: vec3f,
    normal_ws: vec3f,
    offset: f32,
    t_max: f32,        // of every ray, to end before a flat light; negative where the end depends on the ray
    is_before: bool,   // of a one-sided light
};

fn ray_offset(position_ws: vec3f) -> f32 {
    let size = abs(position_ws);
    return OFFSET * max(max(size.x, size.y), max(size.z, tree.extent));
}

fn ray_start(receiver: Receiver) -> RayStart {
    let offset = ray_offset(receiver.position_ws);
    let seen = seen_by(light, receiver);
    var t_max = -1.0;
    if light.is_directional == 1u {
        t_max = 1.0;
    } else if light.is_flat == 1u {
        t_max = 1.0 - ray_offset(light.center_ws) / max(abs(seen.position_ls.z), 1e-30);
    }
    let origin_ws = receiver.position_ws + offset * receiver.normal_ws;
    return RayStart(origin_ws, receiver.normal_ws, offset, t_max, is_on_emitting_side(light, seen));
}

// From the start to a point of the light, in light space.
fn ray_to(start: RayStart, point: vec2f) -> vec3f {
    if light.is_directional == 1u {
        return light.back_ws * (length(start.origin_ws - tree.low_ws) + 2.0 * tree.diagonal);  // past all triangles
    }
    return light.center_ws + point.x * light.right_ws + point.y * light.up_ws - start.origin_ws;
}

// Below the receiver's horizon, or behind a one-sided light, nothing is visible.
fn can_see(start: RayStart, ray: vec3f) -> bool {
    return start.is_before && dot(ray, start.normal_ws) > -start.offset;
}

// The samples that wait for their rays, and the rays.
var<private> waiting: vec4u;
var<private> waiting_count = 0u;
var<private> packet: Packet;

fn begin_packet(start: RayStart) {
    packet.origin_ws = start.origin_ws;
    packet.t_max = vec4f(-1.0);
    waiting_count = 0u;
}

fn add_to_packet(start: RayStart, sample_index: u32, ray: vec3f) {
    let t_max = select(start.t_max, 1.0 - start.offset / max(length(ray), 1e-30), start.t_max < 0.0);
    waiting = vec4u(sample_index, waiting.xyz);
    packet.x = vec4f(ray.x, packet.x.xyz);
    packet.y = vec4f(ray.y, packet.y.xyz);
    packet.z = vec4f(ray.z, packet.z.xyz);
    packet.t_max = vec4f(t_max, packet.t_max.xyz);
    waiting_count += 1u;
}
