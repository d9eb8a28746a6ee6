// Visibility 1 everywhere.

//#include "passes/gbuffer/frame.wgsl"

@group(1) @binding(0) var<storage, read_write> visibility: array<f32>;
@group(1) @binding(1) var<storage, read> layers: array<u32>;  // that are filled

@compute @workgroup_size(8, 8)
fn cs_fill(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < frame.size) {
        visibility[(layers[id.z] * frame.size.y + id.y) * frame.size.x + id.x] = 1.0;
    }
}
