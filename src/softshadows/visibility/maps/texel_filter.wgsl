// The share of lit texels around a receiver's, in a kernel of taps. The including file declares `taps`, in half kernels.

//#needs MapSample, shadow_views, taps, texel_is_lit

fn lit_share(map_sample: MapSample, first_tap: u32, tap_count: u32, half_kernel_texels: f32) -> f32 {
    let view = shadow_views[map_sample.view];
    let texel = (map_sample.position - view.window_low) * view.texels_per_unit;
    var lit = 0.0;
    for (var i = first_tap; i < first_tap + tap_count; i++) {
        let tap = clamp(texel + taps[i] * half_kernel_texels, vec2f(0.0), vec2f(view.size) - 1.0);
        lit += select(0.0, 1.0, texel_is_lit(map_sample, vec2u(tap)));
    }
    return lit / f32(tap_count);
}
