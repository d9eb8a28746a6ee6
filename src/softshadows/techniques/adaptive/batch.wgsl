// A pixel whose tree requests samples of a level, and what kernels that ask about them and remember are bound to.

//#include "passes/gbuffer/receiver.wgsl"
//#include "tree.wgsl"
//#include "level.wgsl"
//#include "visibility_bits.wgsl"

@group(3) @binding(1) var<storage, read> trees: array<u32>;
@group(3) @binding(4) var<storage, read_write> visibility_bits: array<u32>;          // tree.wgsl mask_index()
@group(3) @binding(6) var<storage, read_write> control: Control;

struct LevelPixel {
    is_asked: bool,   // false: beyond the level's tiles, or outside of the image
    tile: u32,
    pixel: vec2u,
};

fn level_pixel(group: vec3u, local: vec3u) -> LevelPixel {
    let list_at = list_index(group);
    if list_at >= atomicLoad(&control.levels[step.level].active_tiles) {
        return LevelPixel(false, 0u, vec2u(0u));
    }
    let tile = control.tile_lists[step.level * tile_count() + list_at];
    let pixel = tile_origin(tile) + local.xy;
    return LevelPixel(all(pixel < frame.size), tile, pixel);
}

// The level's new samples in a row that a tile's tree requests.
fn requested_samples(tile: u32, row: u32) -> u32 {
    return trees[request_index(tree_of(tile), row)] & new_samples(row);
}

// Answers about the samples of a row replace what an earlier frame left about them.
fn remember(tile: u32, lane: u32, row: u32, requested: u32, visible: u32) {
    let pair = mask_index(tile, row / 2u, lane);
    let shift = 16u * (row % 2u);
    visibility_bits[pair] = (visibility_bits[pair] & ~((requested & 0xffffu) << shift)) | ((visible & 0xffffu) << shift);
    if (requested >> 16u) != 0u {
        let lasts = mask_index(tile, mask_words() - 1u, lane);
        visibility_bits[lasts] = insertBits(visibility_bits[lasts], visible >> 16u, row, 1u);
    }
}
