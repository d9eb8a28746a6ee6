// A light as every pass reads it, and light space: metres along the light's right, up and back from its centre. A point of
// the light is (x, y, 0) of it; the light emits along -z.

//#struct Light

fn to_light_space(light: Light, vector_ws: vec3f) -> vec3f {
    return vec3f(dot(vector_ws, light.right_ws), dot(vector_ws, light.up_ws), dot(vector_ws, light.back_ws));
}

// Where an image of `size` pixels keeps the light's visibility of a pixel: [light][y][x].
fn visibility_index(light: Light, pixel: vec2u, size: vec2u) -> u32 {
    return (light.index * size.y + pixel.y) * size.x + pixel.x;
}

// Without size: a point, or a direction.
fn is_point(light: Light) -> bool {
    return max(light.half_width, light.half_height) == 0.0;
}
