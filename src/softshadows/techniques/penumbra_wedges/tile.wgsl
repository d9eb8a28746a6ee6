// A tile of 8×8 receivers, one lane for each.

//#include "passes/gbuffer/receiver.wgsl"
//#struct TileBand

@group(1) @binding(0) var<storage, read> edges: array<WedgeEdge>;
@group(1) @binding(1) var<storage, read> clusters: array<WedgeCluster>;  // of edges, then of triangles
@group(1) @binding(2) var<storage, read> planes: array<vec4f>;
@group(1) @binding(3) var<storage, read> triangle_records: array<vec4u>;
@group(1) @binding(4) var<storage, read_write> visibility: array<f32>;
@group(2) @binding(0) var<storage, read> side: WedgeSide;
@group(3) @binding(0) var<uniform> band: TileBand;

//#include "light_frame.wgsl"

const TILE = 8u;    // pixels along its side
const LANES = 64u;

struct WedgeReceiver {
    exists: bool,         // lies in the image
    is_surface: bool,
    is_lightable: bool,   // shows a surface, and lies before the light
    pixel: u32,           // of this light's visibility
    point: vec3f,         // in light units
    normal: vec3f,        // its product with a vector in light units is that in metres
};

fn wedge_receiver(group: vec2u, local: vec2u) -> WedgeReceiver {
    let pixel = (group + vec2u(0u, band.first_row)) * TILE + local;
    var receiver: WedgeReceiver;
    if any(pixel >= frame.size) {
        return receiver;
    }
    let surface = load_receiver(pixel);
    receiver.exists = true;
    receiver.is_surface = surface.is_surface;
    receiver.pixel = visibility_index(side.light, pixel, frame.size);
    // Free of its own surface by more than rounding can take back.
    receiver.point = to_light_units(surface.position_ws + surface.normal_ws * side.receiver_offset - side.center_ws);
    receiver.normal = normal_in_light_units(surface.normal_ws);
    receiver.is_lightable = surface.is_surface && receiver.point.z < 0.0;
    return receiver;
}

// Place of a receiver's state among those of the band (walk.wgsl).
fn state_index(group: vec2u, lane: u32) -> u32 {
    let columns = (frame.size.x + TILE - 1u) / TILE;
    return (group.y * columns + group.x) * LANES + lane;
}

// The result. Behind a one-sided light there is darkness; a two-sided one comes twice, and its second side leaves the first's be.
fn write_visibility(receiver: WedgeReceiver, share: f32) {
    if receiver.exists && (receiver.is_lightable || side.is_second_side == 0u) {
        let dark_or_empty = select(1.0, 0.0, receiver.is_surface);
        visibility[receiver.pixel] = select(dark_or_empty, share, receiver.is_lightable);
    }
}
