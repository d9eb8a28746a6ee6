// What the segments of a line light give to a receiver, put together: by their lengths, or by the illumination at their ends.
//
// The papers shade at the samples alone: each end of a segment stands for a part of it, and what is lit of that part is weighed
// with the end's own illumination. Over the same sum for the whole light, that is a visibility again: times the unshadowed
// radiance it gives the papers' picture, as bright as the whole light where all of it is seen.

//#needs Receiver, light_samples

override by_ends: bool;

struct Shading {
    visible: f32,  // sum of the segments' visible shares, each times its length between samples
    lit: f32,      // the same, weighed with the ends' illumination
    whole: f32,    // and if all were visible
};

// cos / distance² at the receiver, of light from a sample.
fn end_illumination(sample: u32, receiver: Receiver) -> f32 {
    let from_sample = receiver.position_ls - vec3f(light_samples.points[sample].xy, 0.0);
    let distance = length(from_sample);
    return max(-dot(receiver.normal_ls, from_sample), 0.0) / (distance * distance * distance);
}

// With the segment between two samples. `lit` is what is visible of it and is shaded as its first and as its second end is,
// `whole` the same of the segment that is seen from end to end.
fn with_segment(shading: Shading, start: u32, end: u32, receiver: Receiver, lit: vec2f, whole: vec2f) -> Shading {
    let length = f32(end - start);
    var sum = shading;
    sum.visible += length * (lit.x + lit.y);
    if by_ends {
        let illumination = length * vec2f(end_illumination(start, receiver), end_illumination(end, receiver));
        sum.lit += dot(lit, illumination);
        sum.whole += dot(whole, illumination);
    }
    return sum;
}

// At most 1: where an end that is brighter than the other stands for more than its part, nothing is brighter than without shadow.
fn visibility_of(shading: Shading) -> f32 {
    if shading.whole > 0.0 {
        return select(shading.lit / shading.whole, 1.0, shading.lit >= shading.whole);
    }
    return shading.visible / f32(light_samples.count - 1u);
}
