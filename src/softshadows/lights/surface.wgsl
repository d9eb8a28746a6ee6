// A surface that light falls on: what it is, and what a glTF metallic-roughness surface reflects.
//
// "Surface space" has the surface at its origin and its shading normal as z; "lobe space" is a cosine lobe's own frame with z
// up. Specular reflection is GGX with height-correlated Smith masking and Schlick's Fresnel: evaluated for light from one
// direction; for lights with size by a linearly transformed cosine (Heitz et al. 2016), with the table that
// benchmarks/fit_ltc.py fits.

//#include "gpu/numbers.wgsl"

const DIELECTRIC_REFLECTANCE = 0.04;  // at normal incidence, index of refraction 1.5: glTF 2.0, appendix B
const MIN_ROUGHNESS = 0.045;  // as in benchmarks/fit_ltc.py: below it α⁴ leaves float32's comfortable range
const MIN_VIEW_COSINE = 1e-3;  // the table's grazing row; shading normals can even face away from the viewer

struct Surface {
    position_ws: vec3f,
    normal_ws: vec3f,    // of shading
    view_ws: vec3f,      // unit, towards the eye
    base_color: vec3f,   // linear
    metallic: f32,
    roughness: f32,      // perceptual, 0..1
};

// What a surface reflects towards the viewer, prepared once for all lights.
struct Lobes {
    to_surface: mat3x3f,    // world to (tangent towards the viewer, bitangent, shading normal)
    to_lobe: mat3x3f,       // from there to the space in which the specular lobe is a clamped cosine
    above_horizon: f32,     // share of that cosine that lies above the surface
    specular_albedo: vec3f,
    diffuse_albedo: vec3f,
    reflectance: vec3f,     // Fresnel at normal incidence
};

// Columns tangent (towards `toward`, where that is not the normal itself), bitangent, normal; all in world space.
fn basis_ws(normal: vec3f, toward: vec3f) -> mat3x3f {
    var tangent = toward - normal * dot(normal, toward);
    if dot(tangent, tangent) < 1e-8 {
        tangent = cross(normal, select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.5));
    }
    tangent = normalize(tangent);
    return mat3x3f(tangent, cross(normal, tangent), normal);
}

fn load_bilinear(table: texture_2d<f32>, texel: vec2f) -> vec4f {
    let last = vec2f(textureDimensions(table) - 1u);
    let position = clamp(texel, vec2f(0.0), last);
    let low = vec2u(min(floor(position), last - 1.0));
    let weight = position - vec2f(low);
    let near = mix(textureLoad(table, low, 0), textureLoad(table, low + vec2u(1u, 0u), 0), weight.x);
    let far = mix(textureLoad(table, low + vec2u(0u, 1u), 0), textureLoad(table, low + vec2u(1u, 1u), 0), weight.x);
    return mix(near, far, weight.y);
}

// The two textures hold the table of benchmarks/fit_ltc.py, x = roughness, y = view: its matrix, its albedos.
// Diffuse is scaled by what the specular layer does not reflect of the view direction, where glTF 2.0 appendix B scales
// by 1 - F of the half vector: so an area light and the point light it shrinks to agree, and no energy is gained.
fn shading_lobes(surface: Surface, ltc_matrix: texture_2d<f32>, ltc_albedo: texture_2d<f32>) -> Lobes {
    let cosine = clamp(dot(surface.normal_ws, surface.view_ws), MIN_VIEW_COSINE, 1.0);
    let roughness = max(surface.roughness, MIN_ROUGHNESS);
    let last = vec2f(textureDimensions(ltc_matrix) - 1u);
    let texel = vec2f((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS), sqrt(1.0 - cosine)) * last;
    let m = load_bilinear(ltc_matrix, texel);
    let albedo = load_bilinear(ltc_albedo, texel).xy;

    let reflectance = mix(vec3f(DIELECTRIC_REFLECTANCE), surface.base_color, surface.metallic);
    let dielectric_albedo = mix(albedo.y, albedo.x, DIELECTRIC_REFLECTANCE);
    return Lobes(
        transpose(basis_ws(surface.normal_ws, surface.view_ws)),
        mat3x3f(m.x, 0.0, m.z, 0.0, 1.0, 0.0, m.y, 0.0, m.w),
        0.5 + 0.5 * m.x * inverseSqrt(m.x * m.x + m.z * m.z),
        reflectance * albedo.x + (1.0 - reflectance) * albedo.y,
        surface.base_color * (1.0 - surface.metallic) * (1.0 - dielectric_albedo),
        reflectance,
    );
}
