// Visibility averaged over the 4×4 pixels around each, where the surface goes on and the values differ by no more than noise.

//#include "passes/gbuffer/receiver.wgsl"

@group(1) @binding(0) var<storage, read> noisy: array<f32>;
@group(1) @binding(1) var<storage, read_write> visibility: array<f32>;
@group(1) @binding(2) var<storage, read> layers: array<u32>;  // that are filtered

override noise: f32;             // how far visibility may be off, as a share of the light

const REACH = 2;                 // pixels
const STEEPEST = 0.2;            // out of the receiver's plane, over the way: where one surface goes on
const SMALLEST_COSINE = 0.9;     // between its normals
const FIRST_HALF = 12;           // pixels of the window before its middle, row by row

// The window's ends share one place in the pattern of 4 pixels, so each counts half.
fn pattern_weight(offset: vec2i) -> f32 {
    let halves = select(vec2f(1.0), vec2f(0.5), abs(offset) == vec2i(REACH));
    return halves.x * halves.y;
}

fn value_at(pixel: vec2i, layer: u32) -> f32 {
    return noisy[(layer * frame.size.y + u32(pixel.y)) * frame.size.x + u32(pixel.x)];
}

// Does a pixel show the same surface, in about the same light? From 0 to 1.
fn agreement(here: Receiver, value: f32, pixel: vec2i, layer: u32) -> f32 {
    let difference = (value_at(pixel, layer) - value) / noise;
    if abs(difference) >= 1.0 {
        return 0.0;
    }
    let there = load_receiver(vec2u(pixel));
    let way_ws = there.position_ws - here.position_ws;
    let goes_on = abs(dot(way_ws, here.normal_ws)) <= STEEPEST * length(way_ws)
        && dot(there.normal_ws, here.normal_ws) >= SMALLEST_COSINE;
    return select(0.0, 1.0 - difference * difference, there.is_surface && goes_on);
}

fn is_in_image(pixel: vec2i) -> bool {
    return all(pixel >= vec2i(0)) && all(pixel < vec2i(frame.size));
}

// Where all of the window is as lit as its middle, there is nothing to average.
fn is_even(pixel: vec2i, value: f32, layer: u32) -> bool {
    for (var y = -REACH; y <= REACH; y++) {
        for (var x = -REACH; x <= REACH; x++) {
            let beside = clamp(pixel + vec2i(x, y), vec2i(0), vec2i(frame.size) - 1);
            if value_at(beside, layer) != value {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(8, 8)
fn cs_denoise(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let layer = layers[id.z];
    let pixel = vec2i(id.xy);
    let value = value_at(pixel, layer);
    let here = load_receiver(id.xy);
    if !here.is_surface || is_even(pixel, value, layer) {
        return;
    }
    // Differences are added up, so that equal values stay exactly as they are.
    var change = 0.0;
    var weights = 1.0;
    for (var i = 0; i < FIRST_HALF; i++) {
        let offset = vec2i(i % 5, i / 5) - REACH;
        if !is_in_image(pixel + offset) || !is_in_image(pixel - offset) {
            continue;
        }
        let before = agreement(here, value, pixel + offset, layer);
        let after = agreement(here, value, pixel - offset, layer);
        let weight = pattern_weight(offset) * min(before, after);
        change += weight * (value_at(pixel + offset, layer) + value_at(pixel - offset, layer) - 2.0 * value);
        weights += 2.0 * weight;
    }
    visibility[(layer * frame.size.y + id.y) * frame.size.x + id.x] = value + change / weights;
}
