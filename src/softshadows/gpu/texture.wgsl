// Texture look-ups on the packed pages (gpu/texture_pages.py). truth/alpha.py reads alpha by the same convention:
// texel i covers [i, i + 1) / width, bilinear weights from u * width - 0.5, row 0 at v = 0.

//#include "scene.wgsl"
//#include "packing.wgsl"

// For texels from −1 to 2 * size, which is all that sample_texture_level asks for: no division, which drivers do one by one.
fn wrap_texel(texel: i32, size: i32, mode: u32) -> i32 {
    let period = select(size, 2 * size, mode == 1u);
    var inside = select(texel, texel + period, texel < 0);
    inside = select(inside, inside - period, inside >= period);
    inside = select(inside, inside - period, inside >= period);
    inside = select(inside, 2 * size - 1 - inside, inside >= size);  // only a mirrored texture reaches the second half
    return select(inside, clamp(texel, 0, size - 1), mode == 2u);
}

fn texture_level_size(record: TextureRecord, level: u32) -> vec2i {
    return max(vec2i(record.size >> vec2u(level)), vec2i(1));
}

// Level 0 lies at the record's origin, the others in a column to its right.
fn texture_level_origin(record: TextureRecord, level: u32) -> vec2i {
    var origin = vec2i(record.origin);
    if level > 0u {
        origin.x += i32(record.size.x);
        for (var above = 1u; above < level; above++) {
            origin.y += texture_level_size(record, above).y;
        }
    }
    return origin;
}

fn texture_coordinates(record: TextureRecord, texcoords: vec4f) -> vec2f {
    let uv = vec3f(select(texcoords.xy, texcoords.zw, record.texcoord == 1u), 1.0);
    return vec2f(dot(record.transform_u, uv), dot(record.transform_v, uv));
}

// One level, nearest or bilinear; `is_color` texels are filtered after decoding sRGB.
fn sample_texture_level(record: TextureRecord, uv: vec2f, level: u32, is_color: bool) -> vec4f {
    let size = texture_level_size(record, level);
    // Coordinates far outside lose their fraction in float32; one period is enough for every wrap mode.
    let scaled = select(fract(uv * 0.5) * 2.0, uv, vec2<bool>(record.wrap_u == 2u, record.wrap_v == 2u)) * vec2f(size);
    let place = clamp(scaled, vec2f(-2e9), vec2f(2e9));
    let corner = select(place - 0.5, floor(place), record.nearest == 1u);  // on a texel: the others weigh nothing
    let weight = corner - floor(corner);
    let base = vec2i(floor(corner));
    let x = vec2i(wrap_texel(base.x, size.x, record.wrap_u), wrap_texel(base.x + 1, size.x, record.wrap_u));
    let y = vec2i(wrap_texel(base.y, size.y, record.wrap_v), wrap_texel(base.y + 1, size.y, record.wrap_v));
    let origin = texture_level_origin(record, level);
    let above = mix(
        texture_texel(record.page, origin + vec2i(x[0], y[0]), is_color),
        texture_texel(record.page, origin + vec2i(x[1], y[0]), is_color),
        weight.x,
    );
    let below = mix(
        texture_texel(record.page, origin + vec2i(x[0], y[1]), is_color),
        texture_texel(record.page, origin + vec2i(x[1], y[1]), is_color),
        weight.x,
    );
    return mix(above, below, weight.y);
}

fn texture_texel(page: u32, texel: vec2i, is_color: bool) -> vec4f {
    let value = textureLoad(texture_pages, texel, page, 0);
    return select(value, vec4f(srgb_to_linear(value.rgb), value.a), is_color);
}

// Trilinear; `texcoords_dx`, `texcoords_dy` are the steps to the next pixel to the right and below.
fn sample_texture(record_index: i32, texcoords: vec4f, texcoords_dx: vec4f, texcoords_dy: vec4f, is_color: bool) -> vec4f {
    let record = texture_records[record_index];
    let uv = texture_coordinates(record, texcoords);
    let size = vec2f(record.size);
    let extent_x = length((texture_coordinates(record, texcoords + texcoords_dx) - uv) * size);
    let extent_y = length((texture_coordinates(record, texcoords + texcoords_dy) - uv) * size);
    let level = clamp(log2(max(max(extent_x, extent_y), 1e-6)), 0.0, f32(record.levels - 1u));
    let fine = u32(level);
    let coarse = min(fine + 1u, record.levels - 1u);
    let sharp = sample_texture_level(record, uv, fine, is_color);
    return mix(sharp, sample_texture_level(record, uv, coarse, is_color), fract(level));
}

// Alpha of a masked triangle's point, at level 0: what the alpha cutoff is compared with, for the camera, the shadow maps and
// the truth alike.
fn surface_alpha(material: MaterialRecord, texcoords: vec4f, vertex_alpha: f32) -> f32 {
    var alpha = material.base_color.a * vertex_alpha;
    if material.base_color_texture >= 0 {
        let record = texture_records[material.base_color_texture];
        alpha *= sample_texture_level(record, texture_coordinates(record, texcoords), 0u, false).a;
    }
    return alpha;
}
