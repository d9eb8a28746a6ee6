// The visible share of the light at every pixel: hard tests in all maps, weighed by their channels. [Heidrich2000 §3]

//#include "receiver.wgsl"
//#include "../../passes/line_maps/line_map.wgsl"
//#include "control.wgsl"

@group(1) @binding(0) var<storage, read> control: Control;
@group(1) @binding(1) var channels: texture_2d<f32>;
@group(1) @binding(2) var<storage, read_write> report: array<atomic<u32>>;
@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;

override both_ends_see_all: bool = false;

const ALL_OF_HALF = 0.5;     // of a channel without a skin
const OVERFULL = 1.01;       // a sum of both channels that the clamp takes more than rounding from
const CLAMPED = 0u;          // words of the report

// What a sample knows: whether it is seen, and the shares of the segments before and after it that are seen from its side.
struct Seen {
    is_lit: bool,
    before: f32,
    after: f32,
};

fn look(sample: u32, receiver: LightReceiver) -> Seen {
    let sight = line_sight(sample, receiver);
    if !sight_is_lit(sight) {
        return Seen(false, 0.0, 0.0);
    }
    if !is_rectified(sight) {
        return Seen(true, ALL_OF_HALF, ALL_OF_HALF);
    }
    let found = textureLoad(channels, shadow_views[sight.view].origin + covering_texel(sight), 0).rg;
    let shares = select(found, vec2f(ALL_OF_HALF), found > vec2f(1.0));
    return Seen(true, shares.x, shares.y);
}

@compute @workgroup_size(8, 8)
fn cs_visibility(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = light.visibility_offset + id.y * frame.size.x + id.x;
    let surface = load_receiver(id.xy);
    visibility[pixel] = 1.0;
    if !surface.is_surface {
        return;
    }
    let receiver = light_receiver(surface.position_ws, surface.normal_ws);
    if light.sample_count == 1u {
        visibility[pixel] = select(0.0, 1.0, sight_is_lit(line_sight(0u, receiver)));
        return;
    }
    // [Heidrich2000 §3.3] Segments between neighbouring samples are lights of their own.
    var sum = 0.0;
    var is_overfull = false;
    var sample = 0u;
    var start = look(0u, receiver);
    while sample + 1u < light.sample_count {
        let next = sample_after(control.samples, sample);
        let end = look(next, receiver);
        var share = start.after + end.before;
        if both_ends_see_all && start.is_lit && end.is_lit {
            share = 1.0;
        }
        is_overfull |= share > OVERFULL;
        sum += min(share, 1.0) * f32(next - sample);
        sample = next;
        start = end;
    }
    visibility[pixel] = sum / f32(light.sample_count - 1u);
    if is_overfull {
        atomicAdd(&report[CLAMPED], 1u);
    }
}
