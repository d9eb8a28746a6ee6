// Includes what its includer has already.
//#include "constants.wgsl"

fn doubled(value: u32) -> u32 {
    return 2u * value;
}
