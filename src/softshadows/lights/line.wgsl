// Lines: exact diffuse irradiance by the integral over the angle that they subtend, and the form of linearly transformed cosines
// for lines (Heitz and Hill 2017).

//#include "area_light.wgsl"
//#include "polygon.wgsl"

// Irradiance of the plane z = 0 by the segment a to b, which emits sin(angle to its axis) per metre. With the angle φ
// around the origin, from the foot of the perpendicular on the segment's line, and the distance d of that foot:
// 1 / d² ∫ cos φ (foot_z cos φ + d axis_z sin φ) dφ.
fn segment_irradiance(a: vec3f, b: vec3f) -> f32 {
    if a.z <= 0.0 && b.z <= 0.0 {
        return 0.0;
    }
    let part = above_horizon(a, b);
    let start = part.start;
    let end = part.end;
    let span = end - start;
    let span_length = length(span);
    let axis = span / max(span_length, TINY);
    let start_distance = length(start);
    let end_distance = length(end);
    let along_start = dot(start, axis);
    let along_end = dot(end, axis);
    let foot = select(end - along_end * axis, start - along_start * axis, start_distance < end_distance);
    let d = length(foot);
    if d <= 1e-6 * min(start_distance, end_distance) {
        return 0.0;  // seen end on
    }
    let scale = 1.0 / (start_distance * end_distance);
    let sine = d * span_length * scale;
    let cosine = (d * d + along_start * along_end) * scale;
    let sum_sine = d * (along_start + along_end) * scale;
    let sum_cosine = (d * d - along_start * along_end) * scale;
    let one_plus_sum_cosine = select(sum_sine * sum_sine / (1.0 - sum_cosine), 1.0 + sum_cosine, sum_cosine >= 0.0);
    let bracket = foot.z * (angle_excess(cosine, sine) + one_plus_sum_cosine) + d * axis.z * sum_sine;
    return max(0.5 * sine / (d * d) * bracket, 0.0);
}

// The same for a lobe: the transform stretches the line's width, Heitz and Hill 2017, section 3.
fn segment_lobe_irradiance(to_lobe: mat3x3f, a: vec3f, b: vec3f) -> f32 {
    if a.z <= 0.0 && b.z <= 0.0 {
        return 0.0;
    }
    let part = above_horizon(a, b);
    let lobe_start = to_lobe * part.start;
    let lobe_end = to_lobe * part.end;
    let plane = length(cross(part.start, part.end - part.start));
    let lobe_plane = length(cross(lobe_start, lobe_end - lobe_start));
    let width = determinant(to_lobe) * plane / max(lobe_plane, TINY);
    return width * segment_irradiance(lobe_start, lobe_end);
}

fn line_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    let line = seen_light(light, position_ws, to_surface);
    return segment_irradiance(line.center - line.right, line.center + line.right);
}

fn line_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    let line = seen_light(light, surface.position_ws, lobes.to_surface);
    let irradiance = segment_lobe_irradiance(lobes.to_lobe, line.center - line.right, line.center + line.right);
    return lobe_reflection(irradiance, lobes);
}
