// The space of a tree's boxes and triangles: the world's, along a light's axes (light_tree.py). It begins where the world does,
// not at the light: from a light far off, a small scene's triangles would be rounded coarsely.

//#include "lights/light.wgsl"

@group(0) @binding(6) var<storage, read> light: Light;

fn tree_space(position_ws: vec3f) -> vec3f {
    return to_light_space(light, position_ws);
}
