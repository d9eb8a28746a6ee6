// Visibility of a light, by one walk a pixel and eight words of samples; lights with more take several.

//#include "walk.wgsl"
//#include "gpu/interleaved.wgsl"

@group(2) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(2) @binding(1) var<storage, read_write> report: array<atomic<u32>>;  // not 0: a walk ended before its end

// Neighbours in a workgroup, which run in step, are neighbours in the image: eight of them are 4×2 pixels.
fn pixel_of(group: vec2u, lane: u32) -> vec2u {
    let x = (lane & 3u) | ((lane >> 1u) & 4u);
    let y = ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u);
    return 8u * group + vec2u(x, y);
}

@compute @workgroup_size(64)
fn cs_visibility(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = pixel_of(vec2u(group.x, interleaved_row(group.y, groups.y)), lane);
    if any(pixel >= frame.size) {
        return;
    }
    let index = visibility_index(light, pixel, frame.size);
    let receiver = load_receiver(pixel);
    if !receiver.is_surface {
        visibility[index] = 1.0;
        return;
    }
    let found_before = select(visibility[index], 0.0, row_set.is_first == 1u);
    let is_whole = walk(receiver, pixel);
    visibility[index] = found_before + f32(visible_count()) * row_set.weight;
    if !is_whole {
        atomicOr(&report[0], 1u);
    }
}
