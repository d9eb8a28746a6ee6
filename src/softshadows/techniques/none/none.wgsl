// Visibility 1 everywhere.

@group(0) @binding(0) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(256)
fn cs_fill(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = id.y * groups.x * 256u + id.x;
    if index < arrayLength(&visibility) {
        visibility[index] = 1.0;
    }
}
