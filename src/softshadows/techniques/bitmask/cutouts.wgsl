// Of the samples that a triangle with an alpha mask would hide: those towards which its surface exists. Only samples that
// nothing else hides yet are looked up.

//#include "visibility/rays/masked.wgsl"
//#needs Corners, Marks, View, edge_plane, has_upper_words, hidden_lower, hidden_upper, light_tree, sample_at

const WORDS = vec4u(0u, 1u, 2u, 3u);

fn word_of(marks: Marks, word: u32) -> u32 {
    return select(marks.upper[word & 3u], marks.lower[word & 3u], word < 4u);
}

// Loops, not branches, hold what is rarer (gpu/driver.wgsl).
fn existing(view: View, marks: Marks, corners: Corners, triangle: u32) -> Marks {
    var found = marks;
    for (var is_masked = triangle >= light_tree.opaque_count; is_masked; is_masked = false) {
        let open = Marks(marks.lower & ~hidden_lower, marks.upper & ~hidden_upper);
        let masked = masked_triangles[triangle - light_tree.opaque_count];
        let plane_a = edge_plane(corners.c, corners.b);
        let plane_b = edge_plane(corners.a, corners.c);
        let plane_c = edge_plane(corners.b, corners.a);
        found = Marks();
        for (var word = 0u; word < select(4u, 8u, has_upper_words); word++) {
            var existing_bits = 0u;
            for (var bits = word_of(open, word); bits != 0u; bits &= bits - 1u) {
                let bit = firstTrailingBit(bits);
                let ray = sample_at(view, word, bit);
                let weights = vec3f(dot(plane_a, ray), dot(plane_b, ray), dot(plane_c, ray));
                let exists = masked_surface_exists(masked, weights / (weights.x + weights.y + weights.z));
                existing_bits |= select(0u, 1u << bit, exists);
            }
            found.lower |= select(vec4u(0u), vec4u(existing_bits), WORDS == vec4u(word));
            found.upper |= select(vec4u(0u), vec4u(existing_bits), WORDS + 4u == vec4u(word));
        }
    }
    return found;
}
