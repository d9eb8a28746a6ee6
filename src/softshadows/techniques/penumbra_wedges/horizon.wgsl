// A receiver sees nothing of the light that lies below its own plane.

//#include "tile.wgsl"

// Height above the receiver's plane of the light's point u, metres: x + y u.x + z u.y.
fn horizon(receiver: WedgeReceiver) -> vec3f {
    return vec3f(-dot(receiver.normal, receiver.point), receiver.normal.xy);
}

// The share of the light above the horizon: the area of a square that a line cuts (papers' O2).
fn share_above_horizon(receiver: WedgeReceiver) -> f32 {
    let height = horizon(receiver);
    if is_point(side.light) {
        return select(0.0, 1.0, height.x > 0.0);
    }
    let wide = max(abs(height.y), abs(height.z));
    let narrow = min(abs(height.y), abs(height.z));
    if height.x >= wide + narrow {
        return 1.0;
    }
    if height.x <= -wide - narrow {
        return 0.0;
    }
    if narrow < 1e-4 * wide {
        return saturate(0.5 + 0.5 * height.x / wide);
    }
    let corners = max(vec4f(height.x) + vec4f(wide + narrow, wide - narrow, narrow - wide, -wide - narrow), vec4f(0.0));
    let squares = corners * corners;
    return saturate((squares.x - squares.y - squares.z + squares.w) / (8.0 * wide * narrow));
}
