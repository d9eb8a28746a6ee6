// Running sums over the lanes of a workgroup of 256.

const SUM_LANES = 256u;

var<workgroup> sums: array<u32, SUM_LANES>;

// The sum of the values of all lanes up to this one.
fn sum_up_to(lane: u32, value: u32) -> u32 {
    workgroupBarrier();  // before this, somebody may still read the last sums
    sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < SUM_LANES; reach *= 2u) {
        let before = select(0u, sums[max(lane, reach) - reach], lane >= reach);
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    return sums[lane];
}

// After it: the sum of all values.
fn sum_of_all() -> u32 {
    return sums[SUM_LANES - 1u];
}
