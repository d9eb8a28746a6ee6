// What a receiver knows of the occluded light, quarter by quarter: for the silhouette at hand, and for all before it.
// [Forest2006 §3.1] silhouette visibility buffer, [Forest2006 §3.2] its blending

//#include "coverage.wgsl"

override exact_rectangles: bool = true;
override eight_bits: bool = false;
override uses_gravity: bool = false;

const PARTS = 4u;
const WHOLE = 16777216.0;      // a quarter's area in a sum: sums are whole numbers, so that they do not depend on the edges' order
const NOTHING = 1e-5;          // a share that may be rounding, and must not widen a rectangle
const STEPS = 255.0;           // of an 8-bit number [Forest2006 §4.3]
const GRAVITY_STEPS = 15.0;    // 16 × 16 positions [Forest2006 §6]

// A quarter of the light, mirrored to [0, 1]².
struct Part {
    share: f32,        // occluded area of the quarter
    low: vec2f,        // rectangle around the occluded region
    high: vec2f,
    moments: vec2f,    // first moments of the region
    area_sum: i32,     // share and moments while edges are added
    moment_sum: vec2i,
    corners: vec4f,    // winding numbers of (0, 0), (1, 0), (0, 1), (1, 1)
    has_inner: u32,        // 1 where an inner edge was among them
};

var<private> silhouette: array<Part, PARTS>;
var<private> combined: array<Part, PARTS>;  // zeros: nothing is occluded

fn empty_part() -> Part {
    return Part(0.0, vec2f(1.0), vec2f(0.0), vec2f(0.0), 0, vec2i(0), vec4f(0.0), 0u);
}

fn begin_silhouette(winding: f32) {
    for (var k = 0u; k < PARTS; k++) {
        silhouette[k] = empty_part();
        silhouette[k].area_sum = i32(winding * WHOLE);
        silhouette[k].moment_sum = vec2i(i32(0.5 * winding * WHOLE));
        silhouette[k].corners = vec4f(winding);
    }
}

// Take in an edge with the occluded region on its left for weight 1, on its right for -1. Inner edges, which have the centre on
// the occluded side, take away what lies beyond them; outer ones add it. [Forest2006 §4.3]
fn add_edge(q0: vec3f, q1: vec3f, counter_clockwise: bool, weight: f32) {
    if misses_light(q0, q1) {
        return;
    }
    add_edge_to_part(0u, vec2f(1.0, 1.0), q0, q1, counter_clockwise, weight);
    add_edge_to_part(1u, vec2f(-1.0, 1.0), q0, q1, counter_clockwise, weight);
    add_edge_to_part(2u, vec2f(-1.0, -1.0), q0, q1, counter_clockwise, weight);
    add_edge_to_part(3u, vec2f(1.0, -1.0), q0, q1, counter_clockwise, weight);
}

fn add_edge_to_part(k: u32, mirror: vec2f, q0: vec3f, q1: vec3f, counter_clockwise: bool, weight: f32) {
    let handed = mirror.x * mirror.y;
    let mirror_3 = vec3f(mirror, 1.0);
    let chord = clip_to_quarter(q0 * mirror_3, q1 * mirror_3, counter_clockwise == (handed > 0.0));
    if chord.exists {
        add_chord(k, chord, weight * handed, (weight > 0.0) == counter_clockwise);
    }
}

fn add_chord(k: u32, chord: Chord, weight: f32, is_inner: bool) {
    silhouette[k].area_sum -= i32(round(weight * area_beyond(chord) * WHOLE));
    if uses_gravity {
        silhouette[k].moment_sum -= vec2i(round(weight * moment_beyond(chord) * WHOLE));
    }
    silhouette[k].low = min(silhouette[k].low, min(chord.start, chord.end));
    silhouette[k].high = max(silhouette[k].high, max(chord.start, chord.end));
    if exact_rectangles {
        silhouette[k].corners -= weight * vec4f(0.0, chord.crosses_x, chord.crosses_y, crosses_diagonal(chord));
    } else {
        silhouette[k].has_inner |= u32(is_inner);
    }
}

// The rectangle around the occluded region of the silhouette at hand. The paper's reaches from the lowest end of an edge, or from
// the centre where that is hidden, to the highest, or to the light's border without inner edges. It misses a corner of the quarter
// that is hidden without an edge there; the exact one adds those.
fn finish_rectangle(k: u32) {
    let part = silhouette[k];
    if exact_rectangles {
        let covered = part.corners > vec4f(0.5);
        let low_x = select(1.0, 0.0, covered.x || covered.z);
        let low_y = select(1.0, 0.0, covered.x || covered.y);
        let high_x = select(0.0, 1.0, covered.y || covered.w);
        let high_y = select(0.0, 1.0, covered.z || covered.w);
        silhouette[k].low = min(part.low, vec2f(low_x, low_y));
        silhouette[k].high = max(part.high, vec2f(high_x, high_y));
        return;
    }
    silhouette[k].low = select(part.low, vec2f(0.0), part.corners.x > 0.5);
    silhouette[k].high = select(vec2f(1.0), part.high, part.has_inner == 1u);
}

// Share of the whole light that the silhouette at hand hides, as the standard algorithm has it: not clamped.
fn silhouette_share() -> f32 {
    let quarters = vec4i(silhouette[0].area_sum, silhouette[1].area_sum, silhouette[2].area_sum, silhouette[3].area_sum);
    return dot(vec4f(quarters) / WHOLE, vec4f(0.25));
}

fn combined_share() -> f32 {
    return 0.25 * (combined[0].share + combined[1].share + combined[2].share + combined[3].share);
}

fn packed(value: f32) -> f32 {
    return select(value, round(saturate(value) * STEPS) / STEPS, eight_bits);
}

fn packed2(value: vec2f) -> vec2f {
    return select(value, round(saturate(value) * STEPS) / STEPS, eight_bits);
}

fn gravity_of(part: Part) -> vec2f {
    let center = saturate(part.moments / max(part.share, 1e-6));
    return select(center, round(center * GRAVITY_STEPS) / GRAVITY_STEPS, eight_bits);
}

// Blend the silhouette at hand into what was there before: add, less the overlap. [Forest2006 §3.2]
fn blend_silhouette() {
    for (var k = 0u; k < PARTS; k++) {
        finish_rectangle(k);
        var part = silhouette[k];
        part.share = packed(saturate(f32(part.area_sum) / WHOLE));
        part.moments = vec2f(part.moment_sum) / WHOLE;
        part.low = packed2(part.low);
        part.high = packed2(part.high);
        if part.share <= NOTHING {
            continue;
        }
        let before = combined[k];
        if before.share <= NOTHING {
            combined[k] = part;
            continue;
        }
        combined[k].share = packed(saturate(before.share + part.share - overlap(before, part)));
        combined[k].low = min(before.low, part.low);
        combined[k].high = max(before.high, part.high);
        let weight = before.share / (before.share + part.share);
        combined[k].moments = combined[k].share * mix(gravity_of(part), gravity_of(before), weight);
    }
}

// Estimated area that two regions share: as if each were spread evenly over its rectangle. [Forest2006 §3.2] the formula of ε
fn overlap(first: Part, second: Part) -> f32 {
    let low = max(first.low, second.low);
    let high = min(first.high, second.high);
    let extent = max(high - low, vec2f(0.0));
    let density = share_of_rectangle(first) * share_of_rectangle(second);
    if uses_gravity {
        let along_x = tilted_product(first, second, 0u, low.x, high.x);
        let along_y = tilted_product(first, second, 1u, low.y, high.y);
        return select(0.0, density * along_x * along_y, all(extent > vec2f(0.0)));
    }
    return density * extent.x * extent.y;
}

// Occluded share of the rectangle around a part. The paper's rectangles can be smaller than what they should hold.
fn share_of_rectangle(part: Part) -> f32 {
    let extent = max(part.high - part.low, vec2f(0.0));
    return min(part.share / max(extent.x * extent.y, 1e-12), 1.0);
}

// With the centre of gravity, a region is spread over its rectangle with a density that rises linearly along each axis, as
// steeply as that centre asks and as a positive density allows. Integral of two such factors from low to high.
// [Forest2006 §6] "weight the bounding rectangles intersection area"
fn tilted_product(first: Part, second: Part, axis: u32, low: f32, high: f32) -> f32 {
    let a = tilt(first, axis);
    let b = tilt(second, axis);
    let middle = 0.5 * (low + high);
    let length = high - low;
    return length * ((1.0 + a.y * (middle - a.x)) * (1.0 + b.y * (middle - b.x)) + a.y * b.y * length * length / 12.0);
}

// Middle of the rectangle along an axis, and the slope of the density there over its mean.
fn tilt(part: Part, axis: u32) -> vec2f {
    let low = select(part.low.x, part.low.y, axis == 1u);
    let high = select(part.high.x, part.high.y, axis == 1u);
    let center = gravity_of(part);
    let at = select(center.x, center.y, axis == 1u);
    let middle = 0.5 * (low + high);
    let extent = max(high - low, 1e-6);
    return vec2f(middle, clamp(12.0 * (at - middle) / (extent * extent), -2.0 / extent, 2.0 / extent));
}
