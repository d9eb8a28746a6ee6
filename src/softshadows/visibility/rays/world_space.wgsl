// The space of a tree's boxes and triangles: the world's.

fn tree_space(position_ws: vec3f) -> vec3f {
    return position_ws;
}
