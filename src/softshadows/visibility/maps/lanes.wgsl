// Extents that the lanes of a workgroup found apart, and what texels they ask for, joined: how both kinds of windows reduce.

const LANES = 64u;

var<workgroup> lane_lows: array<vec3f, LANES>;
var<workgroup> lane_highs: array<vec3f, LANES>;
var<workgroup> lane_demands: array<vec2f, LANES>;  // sum of texels asked for per unit of the window, number of pixels

// Every lane's extents and demand become those of all lanes, in the first place. Before the next call, a barrier.
fn join_lanes(lane: u32, low: vec3f, high: vec3f, demand: vec2f) {
    lane_lows[lane] = low;
    lane_highs[lane] = high;
    lane_demands[lane] = demand;
    for (var stride = LANES / 2u; stride > 0u; stride /= 2u) {
        workgroupBarrier();
        if lane < stride {
            lane_lows[lane] = min(lane_lows[lane], lane_lows[lane + stride]);
            lane_highs[lane] = max(lane_highs[lane], lane_highs[lane + stride]);
            lane_demands[lane] += lane_demands[lane + stride];
        }
    }
    workgroupBarrier();
}
