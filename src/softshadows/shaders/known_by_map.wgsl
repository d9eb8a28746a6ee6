// What shadow maps know for certain about a light sample: where all four texels around the look-up agree, by more than the
// bias. Beside silhouettes, contacts and thin occluders they do not, and a ray is asked.

//#include "shadow_map.wgsl"

const CERTAIN_TEXELS = 8.0;  // an occluder this far before the receiver's plane is not the receiver's own neighbourhood

fn map_answer(sample_index: u32, receiver: LightReceiver) -> u32 {
    let sight = sight_through(sample_index, receiver, receiver.point);
    if !sight.covered {
        return select(HIDDEN, LIT, sight.possible);  // nothing was drawn that could shadow it
    }
    let view = shadow_views[sight.view];
    let last = vec2i(view.size) - 1;
    let corner = vec2i(floor((sight.position - view.window_low) * view.texels_per_unit - 0.5));
    let low = vec2u(clamp(corner, vec2i(0), last));
    let high = vec2u(clamp(corner + 1, vec2i(0), last));
    let gaps = vec4f(
        texel_gap(sight, low).texels,
        texel_gap(sight, vec2u(high.x, low.y)).texels,
        texel_gap(sight, vec2u(low.x, high.y)).texels,
        texel_gap(sight, high).texels,
    );
    let is_hidden = all(gaps > vec4f(CERTAIN_TEXELS));
    return select(select(UNKNOWN, HIDDEN, is_hidden), LIT, all(gaps <= vec4f(0.0)));
}
