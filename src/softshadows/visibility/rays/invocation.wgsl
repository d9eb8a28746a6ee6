// The number of an invocation in a dispatch whose workgroups lie in rows, since one row holds 65 535 at most.

const INVOCATIONS = 64u;  // of a workgroup

fn invocation(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * INVOCATIONS + id.x;
}
