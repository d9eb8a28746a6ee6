// Of the samples that a triangle with an alpha mask would hide: those towards which its surface exists. Only samples that
// nothing else hides yet are looked up.

//#include "visibility/rays/masked.wgsl"
//#needs Corners, LOWER_WORDS, NONE, UPPER_WORDS, View, bits_at, edge_plane, has_upper_words, hidden_lower, hidden_upper, hide, sample_at

var<private> marked_lower: vec4u;  // samples that the triangle at hand would hide
var<private> marked_upper: vec4u;

fn mark(word: f32, bits: u32) {
    marked_lower |= bits_at(LOWER_WORDS, word, bits);
    if has_upper_words {
        marked_upper |= bits_at(UPPER_WORDS, word, bits);
    }
}

// Loops, not branches, hold what is rarer (gpu/driver.wgsl).
fn hide_marked(view: View, corners: Corners, triangle: u32) {
    marked_lower &= ~hidden_lower;
    marked_upper &= ~hidden_upper;
    let is_asked = any((marked_lower | marked_upper) != NONE);
    for (var is_masked = is_asked && triangle >= view.opaque_count; is_masked; is_masked = false) {
        let masked = masked_triangles[triangle - view.opaque_count];
        let plane_a = edge_plane(corners.c, corners.b);
        let plane_b = edge_plane(corners.a, corners.c);
        let plane_c = edge_plane(corners.b, corners.a);
        for (var word = 0u; word < select(4u, 8u, has_upper_words); word++) {
            var existing = 0u;
            for (var open = select(marked_upper[word & 3u], marked_lower[word & 3u], word < 4u); open != 0u; open &= open - 1u) {
                let bit = firstTrailingBit(open);
                let ray = sample_at(view, f32(word), bit);
                let weights = vec3f(dot(plane_a, ray), dot(plane_b, ray), dot(plane_c, ray));
                let exists = surface_exists(masked, weights / (weights.x + weights.y + weights.z));
                existing |= select(0u, 1u << bit, exists);
            }
            hide(f32(word), existing);
        }
        marked_lower = NONE;
        marked_upper = NONE;
    }
    hidden_lower |= marked_lower;
    hidden_upper |= marked_upper;
    marked_lower = NONE;
    marked_upper = NONE;
}
