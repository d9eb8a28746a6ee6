// What a walk does at every pixel, for pictures, tests and benchmarks: eleven words each.

//#include "walk.wgsl"

@group(2) @binding(0) var<storage, read_write> looks: array<u32>;  // bits of hidden samples, eight words; boxes; triangles; words

@compute @workgroup_size(8, 8)
fn cs_look(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let receiver = load_receiver(id.xy);
    if !receiver.is_surface || !walk(receiver, id.xy) {
        return;
    }
    let at = 11u * (id.y * frame.size.x + id.x);
    for (var word = 0u; word < 4u; word++) {
        looks[at + word] = hidden_lower[word];
        looks[at + 4u + word] = hidden_upper[word];
    }
    looks[at + 8u] = boxes_met;
    looks[at + 9u] = triangles_met;
    looks[at + 10u] = words_marked;
}
