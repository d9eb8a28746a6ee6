// How many rows the maps drawn in this frame have: the size of the outreach's dispatch.

//#include "edge_map.wgsl"
//#struct LineState

@group(3) @binding(0) var<storage, read> state: LineState;
@group(3) @binding(1) var<storage, read_write> dispatch: vec3u;

@compute @workgroup_size(1)
fn cs_rows() {
    dispatch = vec3u(select(row_count(0u), 0u, state.drawn_now == 0u), light_samples.count, 1u);
}
