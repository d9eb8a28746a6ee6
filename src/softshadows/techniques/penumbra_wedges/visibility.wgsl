// Visibility of a tile's receivers, from the edges and triangles in its shaft. How occluders are combined is the included file's:
// silhouettes blended, or union.wgsl in its place, the layers over 256 points of the light. Each declares
//     states                                 what receivers keep between dispatches; `walk` is a member
//     restore_state(slot), keep_state(slot, walk)
//     add_occluders(lane, receiver, walk)    all in the tile's shaft, or those up to a pause
//     visible_share(receiver)                of the light, once they are all there

//#include "wedges.wgsl"

@compute @workgroup_size(TILE, TILE)
fn cs_visibility(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = state_index(group.xy, lane);
    var kept = vec4u(0u);
    if is_in_parts {
        kept = states[slot].walk;
    }
    var walk = begin_walk(lane, kept);
    if walk.is_done {
        return;
    }
    if is_in_parts {
        restore_state(slot);
    }
    let receiver = wedge_receiver(group.xy, local.xy);
    gather_shafts(lane, receiver);
    add_occluders(lane, receiver, &walk);
    if is_in_parts {
        keep_state(slot, kept_of(walk));
    }
    if !walk.is_paused {
        write_visibility(receiver, visible_share(receiver));
    }
}
