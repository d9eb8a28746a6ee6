// What shadow maps know for certain about a light sample: where all four texels around the look-up agree, by more than the
// bias. Beside silhouettes, contacts and thin occluders they do not, and a ray is asked.

//#include "query.wgsl"
//#include "visibility/maps/shadow_map.wgsl"

const CERTAIN_TEXELS = 8.0;  // an occluder this far before the receiver's plane is not the receiver's own neighbourhood

// gaps() of the occluders in the four texels around the look-up, along one gradient of the receiver's plane, whose inverse depth is
// linear in the window.
fn gaps_around(map_sample: MapSample) -> vec4f {
    let view = shadow_views[map_sample.view];
    let last = vec2i(view.size) - 1;
    let at = (map_sample.position - view.window_low) * view.texels_per_unit;
    let corner = vec2i(floor(at - 0.5));
    let low = vec2u(clamp(corner, vec2i(0), last));
    let high = vec2u(clamp(corner + 1, vec2i(0), last));
    let stored = vec4f(
        stored_inverse_depth(map_sample, low),
        stored_inverse_depth(map_sample, vec2u(high.x, low.y)),
        stored_inverse_depth(map_sample, vec2u(low.x, high.y)),
        stored_inverse_depth(map_sample, high),
    );
    let scale = texel_scale(map_sample);
    let flatness = select(map_sample.plane_offset, map_sample.plane_normal.z * (maps.far - maps.near), light.is_directional == 1u);
    let gradient = map_sample.plane_normal.xy * scale.extent / flatness;  // of the plane's inverse depth, per texel
    let before = vec2f(low) + 0.5 - at;
    let after = vec2f(high) + 0.5 - at;
    let on_plane = map_sample.inverse_depth + gradient.x * vec4f(before.x, after.x, before.x, after.x)
        + gradient.y * vec4f(before.yy, after.yy);
    return gaps(map_sample, scale, stored, on_plane);
}

fn classify_by_map(sample_index: u32, receiver: Receiver) -> u32 {
    let map_sample = project_into_map(sample_index, receiver, receiver.position_ls);
    if !map_sample.covered || !map_sample.possible {
        return select(HIDDEN, LIT, map_sample.possible);  // nothing was drawn that could shadow it
    }
    let gaps = gaps_around(map_sample);
    let is_hidden = all(gaps > vec4f(CERTAIN_TEXELS));
    return select(select(UNKNOWN, HIDDEN, is_hidden), LIT, all(gaps <= vec4f(0.0)));
}
