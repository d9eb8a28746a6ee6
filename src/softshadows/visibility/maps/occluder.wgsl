// Where a vertex falls in a view of the shadow atlas: what both ways of drawing the occluders share.

//#include "gpu/texture.wgsl"
//#struct MapSettings
//#include "lights/light.wgsl"

@group(0) @binding(0) var<storage, read> light: Light;
@group(0) @binding(1) var<uniform> maps: MapSettings;

// The view that an instance stands for (DrawView in structs.py): a vertex buffer that steps per instance.
struct View {
    @location(1) row_x: vec4f,
    @location(2) row_y: vec4f,
    @location(3) row_inverse_depth: vec4f,
    @location(4) row_w: vec4f,
    @location(5) edges: vec4f,
};

struct Projection {
    position_cs: vec4f,
    inside: array<f32, 4>,  // distances from the view's edges, times w; negative outside
};

fn project(position_ws: vec3f, view: View) -> Projection {
    let position = vec4f(position_ws - light.center_ws, 1.0);
    let x = dot(view.row_x, position);
    let y = dot(view.row_y, position);
    let w = dot(view.row_w, position);
    let low = view.edges.xy * w;
    let high = view.edges.zw * w;
    return Projection(
        vec4f(x - w, w - y, dot(view.row_inverse_depth, position), w),
        array<f32, 4>(x - low.x, y - low.y, high.x - x, high.y - y),
    );
}

// A corner of the two triangles that cover the view, from 0 to 2 across the atlas.
fn view_corner(index: u32, view: View) -> vec2f {
    let is_high = vec2<bool>(index == 1u || index == 2u || index == 4u, index == 2u || index == 4u || index == 5u);
    return select(view.edges.xy, view.edges.zw, is_high);
}

fn is_cut_out(triangle: u32, texcoords: vec4f, vertex_alpha: f32) -> bool {
    let material = materials[triangle_material(triangle)];
    return surface_alpha(material, texcoords, vertex_alpha) < material.alpha_cutoff;
}
