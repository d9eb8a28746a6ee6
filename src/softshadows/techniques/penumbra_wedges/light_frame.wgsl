// Light units: from the light's centre along its right and up in halves of its width and height, so that the light is the
// square [-1, 1]², and along its back in metres. What lies before the light has z < 0; its depth is -z.
//
// A receiver p at depth H sees an edge's point X at depth h in the direction of the light's point q.xy / q.z, with
//     q = (X H - p h, H - h):
// homogeneous, so that edges are cut at the light's border before anything is divided, and what is not between the
// receiver and the light falls away by itself. [Forest2006 §4.2]

//#needs side
//#include "lights/light.wgsl"
//#struct WedgeSide
//#struct WedgeEdge
//#struct WedgeCluster

fn to_light_units(vector_ws: vec3f) -> vec3f {
    return vec3f(dot(vector_ws, side.right_per_half), dot(vector_ws, side.up_per_half), dot(vector_ws, side.back_ws));
}

// The normal of a plane, so that its product with a vector in light units is that with the vector in metres.
fn normal_in_light_units(normal_ws: vec3f) -> vec3f {
    return vec3f(dot(normal_ws, side.right_half_ws), dot(normal_ws, side.up_half_ws), dot(normal_ws, side.back_ws));
}

fn on_light(receiver: vec3f, point: vec3f) -> vec3f {
    return vec3f(point.xy * -receiver.z + receiver.xy * point.z, point.z - receiver.z);
}

// On which side of the plane through the light's centre and an edge, given its normal a × b, the receiver lies. One rounding for
// all who ask: whether a triangle hides the centre, and where its edges pass the centre, must never disagree.
fn side_of_center(edge_normal: vec3f, receiver: vec3f) -> bool {
    return fma(edge_normal.x, receiver.x, fma(edge_normal.y, receiver.y, edge_normal.z * receiver.z)) >= 0.0;
}

// Is the receiver in front of a triangle's plane? As exact for every one who asks.
fn is_before(plane: vec4f, receiver: vec3f) -> bool {
    return fma(plane.x, receiver.x, fma(plane.y, receiver.y, fma(plane.z, receiver.z, plane.w))) >= 0.0;
}
