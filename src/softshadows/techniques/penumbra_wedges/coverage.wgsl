// How much of the light an edge cuts off: the area beyond the edge, as seen from the light's centre.
// [Forest2006 §4.3], [Forest2006 §4.2]
//
// The light is [-1, 1]², cut into four quarters around its centre: the paper's radial parts. An edge is mirrored into the
// quarter [0, 1]² and clipped to it. What lies beyond the clipped edge is the part of the quarter between the directions to its
// ends less the triangle that its ends make with the centre: exact, without angles. For an outline of winding number w about the
// centre,     occluded area of the quarter = w - sum of its edges' areas beyond.

// Do both ends of homogeneous q0 q1 lie beyond the same side of the light? Holds for what lies behind the receiver, too.
fn misses_light(q0: vec3f, q1: vec3f) -> bool {
    let beyond_high = (q0.xy > q0.zz) & (q1.xy > q1.zz);
    let beyond_low = (-q0.xy > q0.zz) & (-q1.xy > q1.zz);
    return any(beyond_high | beyond_low);
}

// An edge within a quarter, from `start` to `end`, light units; counter-clockwise about the centre is positive.
struct Chord {
    exists: bool,
    start: vec2f,
    end: vec2f,
    crosses_x: f32,   // +1 where it leaves the x axis, -1 where it ends there: it passes between the centre and (1, 0)
    crosses_y: f32,   // the same on the other side, between the centre and (0, 1)
};

// Clip homogeneous q0 q1 to the quarter 0 ≤ x ≤ z, 0 ≤ y ≤ z. `counter_clockwise` says on which side of it the centre lies, and
// alone decides in which order it meets the axes: an edge that passes the centre within rounding passes it on that side.
fn clip_to_quarter(q0: vec3f, q1: vec3f, counter_clockwise: bool) -> Chord {
    var none: Chord;
    let enters = q0.xy < vec2f(0.0);
    let leaves = q1.xy < vec2f(0.0);
    if any(enters & leaves) {
        return none;
    }
    if (enters.x && leaves.y && counter_clockwise) || (enters.y && leaves.x && !counter_clockwise) {
        return none;  // passes behind the centre
    }
    let enters_at_y_axis = enters.x && (!enters.y || !counter_clockwise);
    let leaves_at_y_axis = leaves.x && (!leaves.y || counter_clockwise);
    let enters_at_x_axis = enters.y && !enters_at_y_axis;
    let leaves_at_x_axis = leaves.y && !leaves_at_y_axis;
    let axes = q0.xy / (q0.xy - q1.xy);  // where along the edge; used only where it crosses
    var start = q0;
    var end = q1;
    if enters_at_y_axis {
        start = max(mix(q0, q1, axes.x), vec3f(0.0)) * vec3f(0.0, 1.0, 1.0);
    } else if enters_at_x_axis {
        start = max(mix(q0, q1, axes.y), vec3f(0.0)) * vec3f(1.0, 0.0, 1.0);
    }
    if leaves_at_y_axis {
        end = max(mix(q0, q1, axes.x), vec3f(0.0)) * vec3f(0.0, 1.0, 1.0);
    } else if leaves_at_x_axis {
        end = max(mix(q0, q1, axes.y), vec3f(0.0)) * vec3f(1.0, 0.0, 1.0);
    }

    // The light's border. An end that is cut off there lies on no axis any more.
    let before = start.z - start.xy;
    let after = end.z - end.xy;
    if any((before < vec2f(0.0)) & (after < vec2f(0.0))) {
        return none;
    }
    let cuts = before / (before - after);
    let from_border = select(vec2f(0.0), cuts, before < vec2f(0.0));
    let to_border = select(vec2f(1.0), cuts, after < vec2f(0.0));
    let first = max(from_border.x, from_border.y);
    let last = min(to_border.x, to_border.y);
    if first >= last {
        return none;
    }
    let clipped_start = mix(start, end, first);
    let clipped_end = mix(start, end, last);
    if min(clipped_start.z, clipped_end.z) <= 0.0 {
        return none;  // touches the receiver itself
    }
    return Chord(
        true,
        clamp(clipped_start.xy / clipped_start.z, vec2f(0.0), vec2f(1.0)),
        clamp(clipped_end.xy / clipped_end.z, vec2f(0.0), vec2f(1.0)),
        select(0.0, 1.0, enters_at_x_axis && first == 0.0) - select(0.0, 1.0, leaves_at_x_axis && last == 1.0),
        select(0.0, 1.0, leaves_at_y_axis && last == 1.0) - select(0.0, 1.0, enters_at_y_axis && first == 0.0),
    );
}

// Area of the quarter from the x axis to the direction of u, counter-clockwise.
fn area_to(u: vec2f) -> f32 {
    let ratio = min(u.x, u.y) / max(max(u.x, u.y), 1e-30);
    return select(1.0 - 0.5 * ratio, 0.5 * ratio, u.y <= u.x);
}

// First moments of the same region: its area times its centre of gravity.
fn moment_to(u: vec2f) -> vec2f {
    let ratio = min(u.x, u.y) / max(max(u.x, u.y), 1e-30);
    let below = vec2f(ratio / 3.0, ratio * ratio / 6.0);
    return select(vec2f(0.5) - below.yx, below, u.y <= u.x);
}

fn triangle_with_center(chord: Chord) -> f32 {
    return 0.5 * (chord.start.x * chord.end.y - chord.end.x * chord.start.y);
}

// Area of the quarter beyond the chord, negative where it runs clockwise about the centre.
fn area_beyond(chord: Chord) -> f32 {
    return area_to(chord.end) - area_to(chord.start) - triangle_with_center(chord);
}

fn moment_beyond(chord: Chord) -> vec2f {
    return moment_to(chord.end) - moment_to(chord.start) - triangle_with_center(chord) * (chord.start + chord.end) / 3.0;
}

// +1 where the chord passes between the centre and the quarter's corner (1, 1), counter-clockwise; -1 clockwise.
fn crosses_diagonal(chord: Chord) -> f32 {
    return select(0.0, 1.0, chord.end.y >= chord.end.x) - select(0.0, 1.0, chord.start.y >= chord.start.x);
}
