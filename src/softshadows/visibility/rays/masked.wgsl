// Triangles with an alpha mask: does their surface exist at a point?

//#include "gpu/texture.wgsl"
//#struct MaskedTriangle

@group(1) @binding(10) var<storage, read> masked_triangles: array<MaskedTriangle>;  // those behind the opaque ones

// At barycentric coordinates, by the texture's level 0, as for the camera and the shadow maps (surface_alpha).
fn surface_exists(triangle: MaskedTriangle, weights: vec3f) -> bool {
    var alpha = triangle.base_alpha * dot(weights, triangle.alphas);
    if triangle.is_textured == 1u {
        let texcoords = weights.x * triangle.texcoords_a + weights.y * triangle.texcoords_b + weights.z * triangle.texcoords_c;
        alpha *= sample_texture_level(triangle.texture, texture_coordinates(triangle.texture, texcoords), 0u, false).a;
    }
    return alpha >= triangle.cutoff;
}
