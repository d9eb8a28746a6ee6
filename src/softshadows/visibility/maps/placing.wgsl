// Windows become views: placed in their sample's tile of the atlas, and listed to be drawn.
//
// The including file says by `map_coordinates(face, vector)` how a vector of light space lies in a face.

//#needs map_coordinates
//#include "light_space.wgsl"
//#struct LightSamples
//#struct ReceiverBox
//#struct DrawView

struct DrawCounter {
    index_count: u32,
    instance_count: atomic<u32>,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
};

// One buffer, for a stage may bind eight on every device.
struct Draws {
    drawn_samples: array<atomic<u32>, DRAWN_WORDS>,  // whose maps are in the atlas, as bits
    keeps_looser_fits: u32,                          // 0: only maps that would be drawn as they are stay
    counters: array<DrawCounter>,                    // DRAWS by chunk
};

@group(0) @binding(0) var<storage, read> light: Light;
@group(0) @binding(1) var<storage, read> light_samples: LightSamples;
@group(0) @binding(2) var<storage, read> receiver_boxes: array<ReceiverBox>;
@group(0) @binding(3) var<storage, read_write> shadow_views: array<ShadowView>;
@group(0) @binding(4) var<storage, read_write> draw_views: array<DrawView>;       // the views in use, by chunk of samples
@group(0) @binding(5) var<storage, read_write> draws: Draws;
@group(0) @binding(7) var<uniform> maps: MapSettings;

const WINDOWS = 7u;
const WIDE_FRONT = 6u;
const DRAWN_WORDS = 128u;  // 4096 samples
const DRAWS = 4u;  // cleared views, solid, opaque, masked triangles
// Where looser fits are kept:
const KEPT_FINENESS = 0.7;  // of the texels along a unit that a new map would have, to keep the old one
const KEPT_ROOM = 0.1;      // of a window's extent, on each side, once the camera has moved
const EMPTY_LOW = vec2f(3e38);
const EMPTY_HIGH = vec2f(-3e38);
const SMALLEST_VIEW = 8.0;     // texels
const SMALLEST_SHARE = 0.0625; // of the tile's edge

// What one lane works on, by face; of the windows the last is the front's wide one.
var<private> windows: array<Window, WINDOWS>;
var<private> views: array<ShadowView, FACES>;

struct Window {
    low: vec2f,
    high: vec2f,
    texels_per_unit: f32,
};

// The range of (x / d) for x in [low, high] and d in [near, far], near > 0.
fn quotient_range(low: f32, high: f32, near: f32, far: f32) -> vec2f {
    return vec2f(low / select(far, near, low < 0.0), high / select(near, far, high < 0.0));
}

fn is_empty(window: Window) -> bool {
    return any(window.low > window.high);
}

fn widen_windows() {
    for (var face = 0u; face < FACES; face++) {
        if !is_empty(windows[face]) {
            let room = KEPT_ROOM * (windows[face].high - windows[face].low);
            windows[face].low -= room;
            windows[face].high += room;
        }
    }
}

// Place the window in `size` texels of the atlas from `origin` on.
fn place(window: Window, origin: vec2f, size: vec2f) -> ShadowView {
    let room = floor(size) - 2.0 * maps.margin_texels;
    let extent = max(window.high - window.low, vec2f(1e-6 * max(maps.window_scale, 1e-20)));
    var texels_per_unit = room / extent;
    if maps.is_auto == 1u {
        texels_per_unit = min(texels_per_unit, vec2f(window.texels_per_unit));
        texels_per_unit = max(texels_per_unit, vec2f(SMALLEST_VIEW) / extent);
    }
    let used = min(ceil(extent * texels_per_unit) + 2.0 * maps.margin_texels, floor(size));
    return ShadowView(window.low - maps.margin_texels / texels_per_unit, texels_per_unit, vec2u(origin), vec2u(used));
}

// The view as rows of a matrix from world positions (relative to the light's centre) to the atlas: x and y from 0 to 2 across it.
fn draw_view(face: u32, sample_ls: vec3f, view: ShadowView) -> DrawView {
    // The face's axes in world space: light space turned into face coordinates, column by column.
    let x = map_coordinates(face, vec3f(light.right_ws.x, light.up_ws.x, light.back_ws.x));
    let y = map_coordinates(face, vec3f(light.right_ws.y, light.up_ws.y, light.back_ws.y));
    let z = map_coordinates(face, vec3f(light.right_ws.z, light.up_ws.z, light.back_ws.z));
    let offset = map_coordinates(face, -sample_ls);
    let a = vec4f(x.x, y.x, z.x, offset.x);
    let b = vec4f(x.y, y.y, z.y, offset.y);
    let d = vec4f(x.z, y.z, z.z, offset.z);
    let one = vec4f(0.0, 0.0, 0.0, 1.0);
    var w = d;
    var inverse_depth_w = one * maps.depth_scale;
    if light.is_directional == 1u {
        w = one;
        inverse_depth_w = (one * maps.far - d) / (maps.far - maps.near);
    }
    let unit = 2.0 / f32(maps.atlas_size);
    let origin = vec2f(view.origin);
    let end = origin + vec2f(view.size);
    return DrawView(
        unit * (view.texels_per_unit.x * (a - view.window_low.x * w) + origin.x * w),
        unit * (view.texels_per_unit.y * (b - view.window_low.y * w) + origin.y * w),
        inverse_depth_w,
        w,
        unit * vec4f(origin, end),
    );
}

// A sample's tile: its number in the atlas, the tiles' size and arrangement, and the chunk that draws it; how fine its texels
// are to be.
struct Slot {
    index: u32,
    tile_size: u32,
    tiles_per_row: u32,
    chunk: u32,
    texels_per_pixel: f32,
};

// Place the windows in the sample's tile: the largest face takes a column of it, the others stack up beside it.
fn place_all(slot: Slot) {
    // Texels asked for, by face.
    var areas: array<f32, FACES>;
    var total = 0.0;
    var largest = 0u;
    for (var face = 0u; face < FACES; face++) {
        let window = windows[face];
        if is_empty(window) {
            continue;
        }
        let extent = (window.high - window.low) * window.texels_per_unit + SMALLEST_VIEW;
        areas[face] = extent.x * extent.y;
        total += areas[face];
        largest = select(largest, face, areas[face] > areas[largest]);
    }

    let tile = f32(slot.tile_size);
    let tile_origin = vec2f(vec2u(slot.index % slot.tiles_per_row, slot.index / slot.tiles_per_row) * slot.tile_size);
    let others = total - areas[largest];
    var column = tile;
    if others > 0.0 {
        column = floor(tile * clamp(areas[largest] / total, 0.25, 0.75));
    }
    var row = 0.0;
    for (var face = 0u; face < FACES; face++) {
        views[face] = ShadowView(vec2f(0.0), vec2f(0.0), vec2u(0u), vec2u(0u));
        if areas[face] == 0.0 {
            continue;
        }
        if face == largest {
            views[face] = place(windows[face], tile_origin, vec2f(column, tile));
        } else {
            let height = floor(tile * (SMALLEST_SHARE + (1.0 - 5.0 * SMALLEST_SHARE) * areas[face] / others));
            views[face] = place(windows[face], tile_origin + vec2f(column, row), vec2f(tile - column, height));
            row += height;
        }
    }
}

// Are the views those that the sample had in the last frame?
fn are_unchanged(sample: u32) -> bool {
    for (var face = 0u; face < FACES; face++) {
        let wanted = views[face];
        let had = shadow_views[sample * FACES + face];
        if any(wanted.size != had.size) || any(wanted.origin != had.origin) || any(wanted.window_low != had.window_low)
            || any(wanted.texels_per_unit != had.texels_per_unit) {
            return false;
        }
    }
    return true;
}

// Do the views that the sample had in the last frame still show all that these would, and nearly as finely?
fn still_serve(sample: u32) -> bool {
    if draws.keeps_looser_fits == 0u {
        return are_unchanged(sample);
    }
    for (var face = 0u; face < FACES; face++) {
        let wanted = views[face];
        if wanted.size.x == 0u {
            continue;
        }
        let had = shadow_views[sample * FACES + face];
        if had.size.x == 0u || any(had.texels_per_unit < KEPT_FINENESS * wanted.texels_per_unit) {
            return false;
        }
        let low = wanted.window_low + maps.margin_texels / wanted.texels_per_unit;
        let high = wanted.window_low + (vec2f(wanted.size) - maps.margin_texels) / wanted.texels_per_unit;
        let had_low = had.window_low + maps.margin_texels / had.texels_per_unit;
        let had_high = had.window_low + (vec2f(had.size) - maps.margin_texels) / had.texels_per_unit;
        // A view's far border is rounded up to whole texels, by up to one of its own.
        if any(low < had_low - 1e-6 * abs(had_low)) || any(high > had_high + 1.0 / wanted.texels_per_unit) {
            return false;
        }
    }
    return true;
}

// Remember the sample's views, and add those in use to the list that its chunk draws.
fn list_views(sample: u32, chunk: u32) {
    let sample_ls = vec3f(light_samples.points[sample].xy, 0.0);
    for (var face = 0u; face < FACES; face++) {
        if views[face].size.x > 0u {
            let first_counter = DRAWS * chunk;
            let place_in_list = atomicAdd(&draws.counters[first_counter].instance_count, 1u);
            for (var draw = 1u; draw < DRAWS; draw++) {
                atomicAdd(&draws.counters[first_counter + draw].instance_count, 1u);
            }
            draw_views[chunk * maps.samples_per_chunk * FACES + place_in_list] = draw_view(face, sample_ls, views[face]);
        }
        shadow_views[sample * FACES + face] = views[face];
    }
}
