// Given packets of four segments: which of them are blocked?

//#include "occluded.wgsl"
//#include "invocation.wgsl"

@group(0) @binding(0) var<storage, read> packets: array<vec4f>;         // by packet: origin, x, y, z, until
@group(0) @binding(1) var<storage, read_write> blocked: array<u32>;     // by packet: a bit for each segment, and one for failure

const CUT_SHORT = 16u;

@compute @workgroup_size(INVOCATIONS)
fn cs_cast(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = invocation(id, groups);
    if index >= arrayLength(&blocked) {
        return;
    }
    let at = 5u * index;
    let is_unoccluded = trace_visibility(Packet(packets[at].xyz, packets[at + 1u], packets[at + 2u], packets[at + 3u], packets[at + 4u]));
    let bits = dot(select(vec4u(1u, 2u, 4u, 8u), vec4u(0u), is_unoccluded), vec4u(1u));
    blocked[index] = bits | select(0u, CUT_SHORT, was_cut_short);
}
