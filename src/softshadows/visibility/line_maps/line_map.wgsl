// Look-ups in the rectified maps of a line light: shadow_map.wgsl, with the faces of line_space.wgsl.

//#include "visibility/maps/shadow_map.wgsl"
//#include "line_space.wgsl"

const COLUMNS = 2u;  // the most in which a tile's faces lie side by side (fit.wgsl)
// From the middle of a surface's last texel to its border. Half a texel in one map; but what either of a segment's two maps
// hides is hidden, and the larger one of two that err by up to half a texel is a sixth too large. Measured between that and
// none: docs/decisions/0011-occluding-edges.md.
const EDGE_TEXELS = 0.36;

// The receiver as light sample `sample_index` sees it. `view % FACES` is the face; only the first LINE_FACES are rectified.
fn line_map_sample(sample_index: u32, receiver: Receiver) -> MapSample {
    let from_sample = receiver.position_ls - vec3f(light_samples.points[sample_index].xy, 0.0);
    var map_sample: MapSample;
    map_sample.plane_offset = dot(receiver.normal_ls, from_sample);
    map_sample.possible = map_sample.plane_offset < 0.0;
    // The front window may reach over the faces beside it.
    var face = FRONT;
    var point = line_face_coordinates(FRONT, from_sample);
    map_sample.covered = is_covered(sample_index * FACES + FRONT, point);
    if !map_sample.covered {
        face = line_face_of(from_sample);
        point = line_face_coordinates(face, from_sample);
        map_sample.covered = is_covered(sample_index * FACES + face, point);
    }
    map_sample.view = sample_index * FACES + face;
    map_sample.position = window_position(point);
    map_sample.inverse_depth = inverse_depth_of(point.z);
    map_sample.plane_normal = line_face_coordinates(face, receiver.normal_ls);
    return map_sample;
}

fn is_rectified(map_sample: MapSample) -> bool {
    return map_sample.covered && map_sample.view % FACES < LINE_FACES;
}

// Inverse depth of the first occluder in a texel of a view, 0 where there is none.
fn map_inverse_depth(view: u32, texel: vec2u) -> f32 {
    return textureLoad(shadow_atlas, shadow_views[view].origin + texel, 0) / maps.depth_scale;
}

// Position along u of a column's centre, or of any place between columns.
fn column_position(view: u32, column: f32) -> f32 {
    return shadow_views[view].window_low.x + (column + 0.5) / shadow_views[view].texels_per_unit.x;
}

// The rows of all faces of a sample, counted one face after the other: a row's view, and its place there.
struct MapRow {
    view: u32,
    row: u32,
};

fn map_row(sample: u32, number: u32) -> MapRow {
    var view = sample * FACES;
    var row = number;
    while row >= shadow_views[view].size.y {
        row -= shadow_views[view].size.y;
        view++;
    }
    return MapRow(view, row);
}

fn row_number(view: u32, row: u32) -> u32 {
    var number = row;
    for (var other = view - view % FACES; other < view; other++) {
        number += shadow_views[other].size.y;
    }
    return number;
}

// How many rows a sample has; its caps' mean nothing and are not counted.
fn row_count(sample: u32) -> u32 {
    var rows = 0u;
    for (var face = 0u; face < LINE_FACES; face++) {
        rows += shadow_views[sample * FACES + face].size.y;
    }
    return rows;
}

// Where the values of a sample's first row lie, in a list of all rows.
fn first_row(sample: u32) -> u32 {
    return sample * COLUMNS * maps.tile_size;
}
