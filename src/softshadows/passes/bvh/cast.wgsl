// Given segments: is each of them blocked?

//#include "occluded.wgsl"

@group(0) @binding(0) var<storage, read> segments: array<vec4f>;        // origin and until, then ray and 0
@group(0) @binding(1) var<storage, read_write> blocked: array<u32>;

@compute @workgroup_size(64)
fn cs_cast(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = id.y * groups.x * 64u + id.x;
    if 2u * index >= arrayLength(&segments) {
        return;
    }
    let start = segments[2u * index];
    blocked[index] = select(0u, 1u, is_blocked(Segment(start.xyz, segments[2u * index + 1u].xyz, start.w)));
}
