// The shaft of a tile of 8×8 receivers (Haines and Wallace 1991): what may hide the light from any of them. It is bounded by a
// plane through each side of the light, as steep as the steepest pyramid from a receiver to the light, and by the lowest
// receiver. What lies outside it is dropped, first whole clusters, then what they hold. It replaces the paper's rasterised
// wedges: a receiver outside a wedge finds that its edge misses the light.
// [Forest2006 §4.2] "a quick test to know whether a fragment is outside the half-wedge"

//#include "tile.wgsl"

const STEEPEST = 1e30;   // slope of a pyramid to a receiver in the light's plane
const SLACK = 1e-5;      // relative: what just touches the shaft is kept

struct Shaft {
    slopes: vec4f,   // growth of the half extents to +x, -x, +y, -y per metre of depth
    half: f32,       // extent at the light: 1, or 0 for the shaft to its centre
    depth: f32,      // of the lowest receiver
};

var<workgroup> steepest_to_border: array<vec4f, LANES>;
var<workgroup> steepest_to_center: array<vec4f, LANES>;
var<workgroup> deepest: array<f32, LANES>;

// The shafts to the light and to its centre, around the lightable receivers of all lanes. The second's depth is the first's.
fn gather_shafts(lane: u32, receiver: WedgeReceiver) {
    let p = receiver.point;
    let depth = max(-p.z, 1e-30);
    let none = vec4f(-STEEPEST);
    let to_border = clamp((vec4f(p.x, -p.x, p.y, -p.y) - 1.0) / depth, none, -none);
    let to_center = clamp(vec4f(p.x, -p.x, p.y, -p.y) / depth, none, -none);
    steepest_to_border[lane] = select(none, to_border, receiver.is_lightable);
    steepest_to_center[lane] = select(none, to_center, receiver.is_lightable);
    deepest[lane] = select(-1.0, depth, receiver.is_lightable);
    for (var step = LANES / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if lane < step {
            steepest_to_border[lane] = max(steepest_to_border[lane], steepest_to_border[lane + step]);
            steepest_to_center[lane] = max(steepest_to_center[lane], steepest_to_center[lane + step]);
            deepest[lane] = max(deepest[lane], deepest[lane + step]);
        }
    }
    workgroupBarrier();
}

fn shaft_to_light() -> Shaft {
    return Shaft(steepest_to_border[0], 1.0, deepest[0]);
}

fn shaft_to_center() -> Shaft {
    return Shaft(steepest_to_center[0], 0.0, deepest[0]);
}

// How far a point lies beyond each side of the shaft; what is between the sides is negative.
fn beyond_sides(shaft: Shaft, point: vec3f) -> vec4f {
    let across = vec4f(point.x, -point.x, point.y, -point.y);
    let reach = shaft.half - shaft.slopes * point.z;
    return across - reach - SLACK * (abs(across) + shaft.half + abs(shaft.slopes * point.z));
}

fn box_in_shaft(shaft: Shaft, low: vec3f, high: vec3f) -> bool {
    let nearest = vec4f(low.x, -high.x, low.y, -high.y);
    let z = select(vec4f(high.z), vec4f(low.z), shaft.slopes > vec4f(0.0));  // where the shaft is widest
    let reach = shaft.half - shaft.slopes * z;
    let slack = SLACK * (abs(nearest) + shaft.half + abs(shaft.slopes * z));
    return low.x <= high.x && all(nearest - reach <= slack) && low.z < 0.0 && -high.z <= shaft.depth * (1.0 + SLACK);
}

fn segment_in_shaft(shaft: Shaft, a: vec3f, b: vec3f) -> bool {
    return all(min(beyond_sides(shaft, a), beyond_sides(shaft, b)) <= vec4f(0.0))
        && min(-a.z, -b.z) <= shaft.depth * (1.0 + SLACK);
}
