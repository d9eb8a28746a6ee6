// Where rays meet a triangle with an alpha mask, does its surface exist?

//#include "gpu/texture.wgsl"

// Those of the hits, at the barycentric coordinates of the triangle's second and third corner, where there is a surface.
fn exists_at(triangle: u32, is_hit: vec4<bool>, weight_b: vec4f, weight_c: vec4f) -> vec4<bool> {
    if !any(is_hit) {
        return is_hit;
    }
    let material = materials[triangle_material(triangle)];
    if material.alpha_cutoff < 0.0 {
        return is_hit;
    }
    let vertices = triangle_vertices(triangle);
    let a = vertex_attributes[vertices.x].texcoords;
    let b = vertex_attributes[vertices.y].texcoords;
    let c = vertex_attributes[vertices.z].texcoords;
    let alphas = vec3f(vertex_color(vertices.x).a, vertex_color(vertices.y).a, vertex_color(vertices.z).a);
    var exists = is_hit;
    for (var ray = 0u; ray < 4u; ray++) {
        if is_hit[ray] {
            let weights = vec3f(1.0 - weight_b[ray] - weight_c[ray], weight_b[ray], weight_c[ray]);
            let texcoords = weights.x * a + weights.y * b + weights.z * c;
            exists[ray] = surface_alpha(material, texcoords, dot(weights, alphas)) >= material.alpha_cutoff;
        }
    }
    return exists;
}
