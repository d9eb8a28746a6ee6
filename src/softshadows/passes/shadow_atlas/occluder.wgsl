// Where a vertex falls in a view of the shadow atlas: what both ways of drawing the occluders share.

//#include "texture.wgsl"
//#struct ShadowLight
//#struct DrawView
//#struct Chunk

@group(0) @binding(0) var<uniform> light: ShadowLight;
@group(0) @binding(1) var<storage, read> draw_views: array<DrawView>;
@group(0) @binding(2) var<uniform> chunk: Chunk;

struct Projection {
    position_cs: vec4f,
    inside: array<f32, 4>,  // distances from the view's edges, times w; negative outside
};

// The projection of a vertex into the view that an instance of the chunk's draw stands for.
fn project(position_ws: vec3f, instance: u32) -> Projection {
    let view = draw_views[chunk.first_view + instance];
    let position = vec4f(position_ws - light.center_ws, 1.0);
    let x = dot(view.row_x, position);
    let y = dot(view.row_y, position);
    let w = dot(view.row_w, position);
    let low = view.edges.xy * w;
    let high = view.edges.zw * w;
    return Projection(
        vec4f(x - w, w - y, dot(view.row_closeness, position), w),
        array<f32, 4>(x - low.x, y - low.y, high.x - x, high.y - y),
    );
}

fn is_cut_out(triangle: u32, texcoords: vec4f, vertex_alpha: f32) -> bool {
    let material = materials[triangle_material(triangle)];
    return surface_alpha(material, texcoords, vertex_alpha) < material.alpha_cutoff;
}
