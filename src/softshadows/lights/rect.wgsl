// Rectangles: exact diffuse irradiance, and a linearly transformed cosine's of the outline.

//#include "area_light.wgsl"
//#include "polygon.wgsl"

// Corner `index` of the rectangle, counted around it, from 0 again after the last.
fn rect_corner(rect: SeenLight, index: u32) -> vec3f {
    let corner = index % 4u;
    let x = select(-1.0, 1.0, corner == 1u || corner == 2u);
    return rect.center + x * rect.right + select(-1.0, 1.0, corner >= 2u) * rect.up;
}

fn rect_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    let rect = seen_light(light, position_ws, to_surface);
    var outline = Outline();
    for (var i = 0u; i < 4u; i++) {
        add_edge(&outline, rect_corner(rect, i), rect_corner(rect, i + 1u));
    }
    return abs(close_outline(outline));
}

fn rect_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    let rect = seen_light(light, surface.position_ws, lobes.to_surface);
    var outline = LobeOutline();
    for (var i = 0u; i < 4u; i++) {
        add_lobe_edge(&outline, lobes.to_lobe, rect_corner(rect, i), rect_corner(rect, i + 1u));
    }
    return lobe_reflection(abs(close_lobe_outline(outline, lobes.to_lobe)), lobes);
}
