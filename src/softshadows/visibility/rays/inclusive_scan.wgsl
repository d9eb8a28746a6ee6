// Inclusive scans over the lanes of a workgroup.

const SCAN_LANES = 256u;
const BLOCK = 2048u;  // items that a workgroup scans, lanes at a time

var<workgroup> sums: array<u32, SCAN_LANES>;

// The sum of the values of all lanes up to this one.
fn inclusive_scan(lane: u32, value: u32) -> u32 {
    workgroupBarrier();  // before this, somebody may still read the last sums
    sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < SCAN_LANES; reach *= 2u) {
        let before = select(0u, sums[max(lane, reach) - reach], lane >= reach);
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    return sums[lane];
}

// After it: the sum of all values.
fn scan_total() -> u32 {
    return sums[SCAN_LANES - 1u];
}
