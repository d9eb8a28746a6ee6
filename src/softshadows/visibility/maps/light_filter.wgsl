// A filter with the light's own shape, as wide as the penumbra behind a blocker. The including file declares `taps`, in half lights.

//#needs Receiver, MapSample, covering_texel, light, project_into_map, taps, texel_is_lit

// Where tap `i` of `count` lies on the light, from -1 to 1: on a line the taps spread over its length.
fn tap_on_light(i: u32, first: u32, count: u32) -> vec2f {
    let on_line = vec2f((2.0 * f32(i) + 1.0) / f32(count) - 1.0, 0.0);
    return select(taps[first + i], on_line, light.half_height == 0.0);
}

// A tap outside a round light does not count.
fn is_on_light(tap: vec2f) -> bool {
    return light.is_round == 0u || dot(tap, tap) <= 1.0;
}

// The receiver as the light's centre sees it beside the receiver's point, `offset` metres parallel to the light.
fn map_sample_beside(receiver: Receiver, offset: vec2f) -> MapSample {
    return project_into_map(0u, receiver, receiver.position_ls + vec3f(offset, 0.0));
}

// Half the extent, at the receiver's depth, of the region in which a blocker `ratio` times as close as the receiver hides some of
// the light. [Fernando2005 §penumbra estimation] w (d_receiver - d_blocker) / d_blocker
fn penumbra_half_extent(ratio: f32) -> vec2f {
    return vec2f(light.half_width, light.half_height) * max(ratio - 1.0, 0.0);
}

// [Fernando2005 §filtering] The share of lit taps in a kernel as wide as the penumbra.
fn filter_shadow(receiver: Receiver, half_extent: vec2f, first_tap: u32, tap_count: u32) -> f32 {
    var lit = 0.0;
    var count = 0.0;
    for (var i = 0u; i < tap_count; i++) {
        let tap = tap_on_light(i, first_tap, tap_count);
        let map_sample = map_sample_beside(receiver, tap * half_extent);
        if !is_on_light(tap) || !map_sample.covered {
            continue;  // beyond the map nothing is known
        }
        count += 1.0;
        lit += select(0.0, 1.0, texel_is_lit(map_sample, covering_texel(map_sample)));
    }
    return select(0.0, lit / count, count > 0.0);
}
