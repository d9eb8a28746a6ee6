// Triangles with an alpha mask: does their surface exist at a point?

//#include "gpu/texture.wgsl"
//#struct MaskedTriangle

@group(1) @binding(10) var<storage, read> masked_triangles: array<MaskedTriangle>;  // those behind the opaque ones

// A masked triangle with the record of its texture: loaded once, for all points that are looked at.
struct MaskedSurface {
    triangle: MaskedTriangle,
    texture: TextureRecord,
};

// By its place among the masked triangles.
fn load_masked_surface(index: u32) -> MaskedSurface {
    let triangle = masked_triangles[index];
    return MaskedSurface(triangle, texture_records[max(triangle.texture, 0)]);
}

// At barycentric coordinates, by the texture's level 0, as for the camera and the shadow maps (surface_alpha).
fn surface_exists(surface: MaskedSurface, weights: vec3f) -> bool {
    let triangle = surface.triangle;
    var alpha = triangle.base_alpha * dot(weights, triangle.alphas);
    if triangle.texture >= 0 {
        let texcoords = weights.x * triangle.texcoords_a + weights.y * triangle.texcoords_b + weights.z * triangle.texcoords_c;
        alpha *= sample_texture_level(surface.texture, texture_coordinates(surface.texture, texcoords), 0u, false).a;
    }
    return alpha >= triangle.cutoff;
}
