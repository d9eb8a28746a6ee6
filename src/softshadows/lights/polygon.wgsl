// Irradiance of the plane z = 0 by an outline seen from the origin, for radiance 1: Lambert's polygon formula (Baum et al. 1989),
// with the outline cut at the horizon. In float32 the relative error is below 5e-7 divided by the angle in radians that the
// light subtends.

//#include "gpu/numbers.wgsl"

// Θ / sin Θ - 1 for 0 ≤ Θ < π. A least-squares fit in 1 - cos Θ on 0..π/2, relative error of the ratio below 2e-7.
fn angle_excess(cosine: f32, sine: f32) -> f32 {
    let y = 1.0 - min(abs(cosine), 1.0);
    let excess = y * (0.333333428 + y * (0.133325029 + y * (0.057318703 + y * (0.023834125 + y * (0.018691399
        + y * (-0.013031272 + y * (0.029515536 + y * (-0.02054973 + y * 0.008358974))))))));
    return select(PI / max(sine, TINY) - excess - 2.0, excess, cosine >= 0.0);
}

// An outline that is being cut at the horizon, and the sum over the edges so far. The parts are convex, so they leave
// and enter the upper half space at most once.
struct Outline {
    irradiance: f32,
    leaves: vec3f,
    enters: vec3f,
};

struct Segment {
    start: vec3f,
    end: vec3f,
};

fn horizon_point(a: vec3f, b: vec3f) -> vec3f {
    return vec3f((a.xy * b.z - b.xy * a.z) / (b.z - a.z), 0.0);
}

// The part of the segment from a to b above the horizon, which has to have one.
fn above_horizon(a: vec3f, b: vec3f) -> Segment {
    var part = Segment(a, b);
    if a.z <= 0.0 {
        part.start = horizon_point(a, b);
    }
    if b.z <= 0.0 {
        part.end = horizon_point(a, b);
    }
    return part;
}

// Lambert's term of one edge: half its angle times the height of the unit normal of its plane through the origin.
fn edge_irradiance(a: vec3f, b: vec3f) -> f32 {
    let scale = 1.0 / max(length(a) * length(b), TINY);
    let normal = cross(a, b - a) * scale;  // as cross(a, b), but short edges keep their digits
    return 0.5 * normal.z * (1.0 + angle_excess(dot(a, b) * scale, length(normal)));
}

fn add_edge(outline: ptr<function, Outline>, a: vec3f, b: vec3f) {
    if a.z <= 0.0 && b.z <= 0.0 {
        return;
    }
    let part = above_horizon(a, b);
    if a.z <= 0.0 {
        (*outline).enters = part.start;
    }
    if b.z <= 0.0 {
        (*outline).leaves = part.end;
    }
    (*outline).irradiance += edge_irradiance(part.start, part.end);
}

// Irradiance of the closed outline; its sign is that of the winding.
fn close_outline(outline: Outline) -> f32 {
    return outline.irradiance + edge_irradiance(outline.leaves, outline.enters);
}

// An outline cut at the surface's horizon and then, transformed, at the lobe's.
struct LobeOutline {
    leaves: vec3f,  // surface space
    enters: vec3f,
    lobe: Outline,  // lobe space
};

fn add_lobe_edge(outline: ptr<function, LobeOutline>, to_lobe: mat3x3f, a: vec3f, b: vec3f) {
    if a.z <= 0.0 && b.z <= 0.0 {
        return;
    }
    let part = above_horizon(a, b);
    if a.z <= 0.0 {
        (*outline).enters = part.start;
    }
    if b.z <= 0.0 {
        (*outline).leaves = part.end;
    }
    var lobe = (*outline).lobe;
    add_edge(&lobe, to_lobe * part.start, to_lobe * part.end);
    (*outline).lobe = lobe;
}

fn close_lobe_outline(outline: LobeOutline, to_lobe: mat3x3f) -> f32 {
    var lobe = outline.lobe;
    add_edge(&lobe, to_lobe * outline.leaves, to_lobe * outline.enters);
    return close_outline(lobe);
}
