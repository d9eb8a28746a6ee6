// Includes a file twice and one that does not compile.
//#include "constants.wgsl"
//#include "nested.wgsl"

@group(0) @binding(0) var<storage, read_write> result: array<u32>;

@compute @workgroup_size(1)
fn cs_test() {
    result[0] = ANSWER + doubled(ANSWER);
}
