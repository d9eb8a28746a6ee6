// A mistake in line 4 of the file that is included.
//#include "broken_part.wgsl"

@compute @workgroup_size(1)
fn cs_test() {
}
