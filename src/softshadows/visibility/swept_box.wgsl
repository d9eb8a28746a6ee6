// What can shadow what, by boxes alone.

const TOUCHING = 1e-6;  // of the way to the light: an occluder that begins and ends nearer is the receiver itself

// Does the box [low, high] meet any segment from a point of the receivers' box to a point of the light's box?
//
// At the share t of the way, the segments fill the box from mix(receivers.low, light.low, t) to mix(receivers.high,
// light.high, t); along each axis it overlaps [low, high] in a range of t.
fn can_shadow(low: vec3f, high: vec3f, receivers_low: vec3f, receivers_high: vec3f, light_low: vec3f, light_high: vec3f) -> bool {
    var range = vec2f(0.0, 1.0);
    for (var axis = 0u; axis < 3u; axis++) {
        // mix(receivers_low, light_low, t) <= high  and  mix(receivers_high, light_high, t) >= low, as offset + slope t <= 0
        let offsets = vec2f(receivers_low[axis] - high[axis], low[axis] - receivers_high[axis]);
        let slopes = vec2f(light_low[axis] - receivers_low[axis], receivers_high[axis] - light_high[axis]);
        for (var side = 0u; side < 2u; side++) {
            let offset = offsets[side];
            let slope = slopes[side];
            if slope == 0.0 {
                range.y = select(range.y, -1.0, offset > 0.0);
            } else if slope > 0.0 {
                range.y = min(range.y, -offset / slope);
            } else {
                range.x = max(range.x, -offset / slope);
            }
        }
    }
    return range.x <= range.y && range.y > TOUCHING;
}
