// What an edge leaves of a segment of the light.

// [Reimann2016 §3.4 substep 4.3] i = sin β sin δ / (sin α sin(π - δ - γ)): how much of the segment is lit before the line from
// the fragment through the edge meets it. In a rectified map, where both lie in one row, the law of sines comes down to how
// far the edge is ahead, over how far it would move as the sample goes from end to end of the segment.
fn visible_share(ahead: f32, closer: f32, segment: f32) -> f32 {
    let moves = closer * segment;
    if moves <= ahead || moves <= 0.0 {
        return 1.0;  // not before the fragment, or passed beyond the segment's end
    }
    return clamp(ahead / moves, 0.0, 1.0);
}
