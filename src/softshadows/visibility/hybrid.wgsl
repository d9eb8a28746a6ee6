// What shadow maps know for certain about a light sample: where all four texels around the look-up agree, by more than the
// bias. Beside silhouettes, contacts and thin occluders they do not, and a ray is asked.

//#include "query.wgsl"
//#include "visibility/maps/shadow_map.wgsl"

const CERTAIN_TEXELS = 8.0;  // an occluder this far before the receiver's plane is not the receiver's own neighbourhood

// gaps() of the occluders in the four texels around the look-up, along one gradient of the receiver's plane, whose closeness is
// linear in the window.
fn gaps_around(sight: Sight) -> vec4f {
    let view = shadow_views[sight.view];
    let last = vec2i(view.size) - 1;
    let at = (sight.position - view.window_low) * view.texels_per_unit;
    let corner = vec2i(floor(at - 0.5));
    let low = vec2u(clamp(corner, vec2i(0), last));
    let high = vec2u(clamp(corner + 1, vec2i(0), last));
    let stored = vec4f(
        stored_closeness(sight, low),
        stored_closeness(sight, vec2u(high.x, low.y)),
        stored_closeness(sight, vec2u(low.x, high.y)),
        stored_closeness(sight, high),
    );
    let scale = texel_scale(sight);
    let flatness = select(sight.plane_offset, sight.plane_normal.z * (maps.far - maps.near), light.is_directional == 1u);
    let gradient = sight.plane_normal.xy * scale.extent / flatness;  // of the plane's closeness, per texel
    let before = vec2f(low) + 0.5 - at;
    let after = vec2f(high) + 0.5 - at;
    let on_plane = sight.closeness + gradient.x * vec4f(before.x, after.x, before.x, after.x)
        + gradient.y * vec4f(before.yy, after.yy);
    return gaps(sight, scale, stored, on_plane);
}

fn map_answer(sample_index: u32, receiver: Receiver) -> u32 {
    let sight = sight_through(sample_index, receiver, receiver.position_ls);
    if !sight.covered || !sight.possible {
        return select(HIDDEN, LIT, sight.possible);  // nothing was drawn that could shadow it
    }
    let gaps = gaps_around(sight);
    let is_hidden = all(gaps > vec4f(CERTAIN_TEXELS));
    return select(select(UNKNOWN, HIDDEN, is_hidden), LIT, all(gaps <= vec4f(0.0)));
}
