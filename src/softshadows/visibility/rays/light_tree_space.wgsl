// The space of a tree's boxes and triangles: a light's (light_tree.py).

//#include "lights/light.wgsl"

@group(0) @binding(6) var<storage, read> light: Light;

fn tree_space(position_ws: vec3f) -> vec3f {
    return to_light_space(light, position_ws - light.center_ws);
}
