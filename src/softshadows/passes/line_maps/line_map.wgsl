// Look-ups in the rectified maps of a line light: shadow_map.wgsl, with the faces of line_space.wgsl.

//#include "shadow_map.wgsl"
//#include "line_space.wgsl"

// The receiver as light sample `sample_index` sees it. `view % FACES` is the face; only the first LINE_FACES are rectified.
fn line_sight(sample_index: u32, receiver: LightReceiver) -> Sight {
    let from_sample = receiver.point - vec3f(light_samples[sample_index].xy, 0.0);
    var sight: Sight;
    sight.plane_offset = dot(receiver.normal, from_sample);
    sight.possible = sight.plane_offset < 0.0;
    // The front window may reach over the faces beside it.
    var face = FRONT;
    var point = line_face_coordinates(FRONT, from_sample);
    sight.covered = is_covered(sample_index * FACES + FRONT, point);
    if !sight.covered {
        face = line_face_of(from_sample);
        point = line_face_coordinates(face, from_sample);
        sight.covered = is_covered(sample_index * FACES + face, point);
    }
    sight.view = sample_index * FACES + face;
    sight.position = window_position(light, point);
    sight.closeness = closeness_of(light, point.z);
    sight.plane_normal = line_face_coordinates(face, receiver.normal);
    return sight;
}

fn is_rectified(sight: Sight) -> bool {
    return sight.covered && sight.view % FACES < LINE_FACES;
}

// Closeness of the first occluder in a texel of a view, 0 where there is none.
fn map_closeness(view: u32, texel: vec2u) -> f32 {
    return textureLoad(shadow_atlas, shadow_views[view].origin + texel, 0) / light.depth_scale;
}

// Position along u of a column's centre, or of any place between columns.
fn column_position(view: u32, column: f32) -> f32 {
    return shadow_views[view].window_low.x + (column + 0.5) / shadow_views[view].texels_per_unit.x;
}
