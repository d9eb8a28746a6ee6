// [Reimann2016 §3.4 substep 4.3] How much of the lit part of a segment is shaded as its first end is, and how much as its
// second: the areas B and A between it and f, which says of every place what influence the second end has there.

//#needs PARTS, by_ends, influence, share_of_rest

// The integral of f from the segment's first end; f is linear between the places of its table.
fn influence_up_to(share: f32) -> f32 {
    let last = arrayLength(&influence) - 1u;
    let place = clamp(share, 0.0, 1.0) * f32(last);
    let number = min(u32(place), last - 1u);
    let along = place - f32(number);
    let here = influence[number];
    let slope = influence[number + 1u].x - here.x;
    return here.y + along * (here.x + 0.5 * slope * along) / f32(last);
}

// (B, A) of what lies between two shares of the segment; where the ends are not shaded apart, all of it is B.
fn influence_between(low: f32, high: f32) -> vec2f {
    let lit = max(high - low, 0.0);
    if !by_ends {
        return vec2f(lit, 0.0);
    }
    let of_second = influence_up_to(low + lit) - influence_up_to(low);
    return vec2f(lit - of_second, of_second);
}

// (B, A) of the parts of the segment that are not hidden, one bit each.
fn influence_of_rest(hidden: vec4u) -> vec2f {
    if !by_ends || all(hidden == vec4u(0u)) {
        return influence_between(0.0, share_of_rest(hidden));
    }
    var sum = vec2f(0.0);
    for (var part = 0u; part < PARTS; part++) {
        if ((hidden[part / 32u] >> (part % 32u)) & 1u) == 0u {
            sum += influence_between(f32(part) / f32(PARTS), f32(part + 1u) / f32(PARTS));
        }
    }
    return sum;
}
