// How shadow maps lie in light space, where a light sample is a point (x, y, 0). The including file declares `light` and
// `maps`.
//
// A sample's surroundings are cut into the six faces of a cube that is aligned with light space, and a direction has
// face coordinates (a, b, d): d > 0 along the face's axis, a and b across; left-handed in all six, so that a triangle that
// faces the light is wound alike in every map. A shadow map of a face is a window in the tangents (a / d, b / d) and
// holds inverse depth = 1 / d, which is linear in the map's image wherever the surface is a plane.
// A directional light has one face, the window is in metres (a, b), and inverse depth = (far - d) / (far - near).

//#needs light, maps
//#include "lights/light.wgsl"
//#struct MapSettings
//#struct ShadowView

const FACES = 6u;
const FRONT = 0u;  // along -z, where a one-sided light emits
const BACK = 5u;

fn face_coordinates(face: u32, v: vec3f) -> vec3f {
    switch face {
        case 0u: { return vec3f(v.x, v.y, -v.z); }
        case 1u: { return vec3f(-v.y, v.z, v.x); }
        case 2u: { return vec3f(v.y, v.z, -v.x); }
        case 3u: { return vec3f(v.x, v.z, v.y); }
        case 4u: { return vec3f(-v.x, v.z, -v.y); }
        default: { return vec3f(-v.x, v.y, v.z); }
    }
}

// The face that the direction `v` points through.
fn face_of(v: vec3f) -> u32 {
    if light.is_directional == 1u {
        return FRONT;
    }
    let size = abs(v);
    if size.z >= max(size.x, size.y) {
        return select(FRONT, BACK, v.z > 0.0);
    }
    if size.x >= size.y {
        return select(1u, 2u, v.x < 0.0);
    }
    return select(3u, 4u, v.y < 0.0);
}

// Position in the window's plane, of a point with face coordinates `point`.
fn window_position(point: vec3f) -> vec2f {
    return select(point.xy / point.z, point.xy, light.is_directional == 1u);
}

fn inverse_depth_of(depth: f32) -> f32 {
    return select(1.0 / depth, (maps.far - depth) / (maps.far - maps.near), light.is_directional == 1u);
}

// Inverse depth of the plane {x : dot(normal, x) = offset} in face coordinates, at `position` in the window's plane.
fn plane_inverse_depth(normal: vec3f, offset: f32, position: vec2f) -> f32 {
    if light.is_directional == 1u {
        return inverse_depth_of((offset - dot(normal.xy, position)) / normal.z);
    }
    return dot(normal, vec3f(position, 1.0)) / offset;
}

// How much the plane's inverse depth changes over one texel.
fn inverse_depth_per_texel(normal: vec3f, offset: f32, texel_extent: vec2f) -> f32 {
    let across = dot(abs(normal.xy), texel_extent);
    return select(across / abs(offset), across / (abs(normal.z) * (maps.far - maps.near)), light.is_directional == 1u);
}

// The difference in inverse depth that a step towards the light makes, as long as a texel of this extent is wide at the receiver.
fn inverse_depth_of_extent(inverse_depth: f32, texel_extent: f32) -> f32 {
    return select(texel_extent * inverse_depth, texel_extent / (maps.far - maps.near), light.is_directional == 1u);
}
