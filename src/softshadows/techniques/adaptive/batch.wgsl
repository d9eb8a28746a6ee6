// A pixel that is asked about a batch of a level's samples, and what kernels that ask and remember are bound to.

//#include "receiver.wgsl"
//#include "tree.wgsl"
//#include "level.wgsl"

@group(3) @binding(1) var<storage, read> requests: array<u32>;
@group(3) @binding(4) var<storage, read_write> masks: array<u32>;          // tree.wgsl mask_index()
@group(3) @binding(5) var<storage, read> active_tiles: array<u32>;
@group(3) @binding(6) var<storage, read_write> control: Control;

struct BatchPixel {
    is_asked: bool,   // false: beyond the level's tiles or samples, or outside of the image
    tile: u32,
    pixel: vec2u,
};

fn batch_pixel(group: vec3u, local: vec3u) -> BatchPixel {
    let list_at = list_index(group);
    if list_at >= atomicLoad(&control.levels[step.level].active_tiles) || step.first_rank >= level_samples() {
        return BatchPixel(false, 0u, vec2u(0u));
    }
    let tile = active_tiles[step.level * tile_count() + list_at];
    let pixel = tile_origin(tile) + local.xy;
    return BatchPixel(all(pixel < frame.size), tile, pixel);
}

// Samples that the level asks about, and the end of those in the batch.
fn level_samples() -> u32 {
    return control.levels[step.level].sample_count;
}

fn batch_end() -> u32 {
    return min(step.first_rank + step.samples_per_batch, level_samples());
}
