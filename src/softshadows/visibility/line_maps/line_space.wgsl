// Where rectified maps lie around a line light: four faces around the light's axis and two caps beyond its ends.
//
// A face has coordinates (a, b, d): a along the light, in its own direction on all four faces; d > 0 along the face's axis
// and b across both. Seen from any point of the line, a point has the same b and d: in the tangents u = a / d along the
// light and v = b / d around it, an image row (constant v) is a plane through the light, inverse depth 1 / d is the same in
// every sample's map, and from the sample at x0 to the one at x1 a point moves by (x0 - x1) / d along u.
// All faces are left-handed (light_space.wgsl). Each goes on at v = 1 where the next begins at v = -1.
// The caps hold what lies beyond LINE_LIMIT, seen nearly along the light; their rows mean nothing.

//#include "visibility/maps/light_space.wgsl"

const LINE_FACES = 4u;
const LINE_LIMIT = 4.0;  // the largest |u| of a face, 76 degrees

fn line_face_coordinates(face: u32, v: vec3f) -> vec3f {
    switch face {
        case 0u: { return vec3f(v.x, v.y, -v.z); }
        case 1u: { return vec3f(v.x, v.z, v.y); }
        case 2u: { return vec3f(v.x, -v.y, v.z); }
        case 3u: { return vec3f(v.x, -v.z, -v.y); }
        case 4u: { return vec3f(-v.y, v.z, v.x); }
        default: { return vec3f(v.y, v.z, -v.x); }
    }
}

// The face that the direction `v` points through.
fn line_face_of(v: vec3f) -> u32 {
    let size = abs(v);
    if size.x > LINE_LIMIT * max(size.y, size.z) {
        return select(4u, 5u, v.x < 0.0);
    }
    if size.z >= size.y {
        return select(0u, 2u, v.z > 0.0);
    }
    return select(1u, 3u, v.y < 0.0);
}

// How far along u a point of this inverse depth moves from the map of the sample at `from_x` to that of the one at `to_x`.
fn disparity(from_x: f32, to_x: f32, inverse_depth: f32) -> f32 {
    return (from_x - to_x) * inverse_depth;
}
