// Where rays meet a triangle with an alpha mask, does its surface exist?

//#include "masked.wgsl"
//#needs tree

// Those of the hits, at the barycentric coordinates of the triangle's second and third corner, where there is a surface.
fn exists_at(triangle: u32, is_hit: vec4<bool>, weight_b: vec4f, weight_c: vec4f) -> vec4<bool> {
    let index = triangle - tree.opaque_count;  // of an opaque one: past all masked ones
    if !any(is_hit) || index >= arrayLength(&masked_triangles) {
        return is_hit;
    }
    let masked = masked_triangles[index];
    var exists = is_hit;
    for (var ray = 0u; ray < 4u; ray++) {
        if is_hit[ray] {
            let weights = vec3f(1.0 - weight_b[ray] - weight_c[ray], weight_b[ray], weight_c[ray]);
            exists[ray] = surface_exists(masked, weights);
        }
    }
    return exists;
}
