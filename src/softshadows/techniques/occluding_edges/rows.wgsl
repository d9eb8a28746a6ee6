// How many rows the maps drawn in this frame have: the size of the outreach's dispatch.

//#include "edge_map.wgsl"
//#struct LineState

@group(3) @binding(0) var<storage, read> state: LineState;
@group(3) @binding(1) var<storage, read_write> dispatch: vec3u;

@compute @workgroup_size(1)
fn cs_rows() {
    var rows = 0u;
    for (var face = 0u; face < LINE_FACES; face++) {
        rows += shadow_views[face].size.y;  // as in every other sample
    }
    dispatch = vec3u(select(rows, 0u, state.drawn_now == 0u), light.sample_count, 1u);
}
