// A pixel's answers about the samples of a batch, remembered as bits.

//#include "tree.wgsl"
//#include "level.wgsl"

@group(3) @binding(1) var<storage, read> requests: array<u32>;
@group(3) @binding(4) var<storage, read_write> masks: array<u32>;          // tree.wgsl mask_index()

// Answers about the samples of a row replace what an earlier frame left about them.
fn remember(tile: u32, lane: u32, row: u32, requested: u32, visible: u32) {
    let pair = mask_index(tile, row / 2u, lane);
    let shift = 16u * (row % 2u);
    masks[pair] = (masks[pair] & ~((requested & 0xffffu) << shift)) | ((visible & 0xffffu) << shift);
    if (requested >> 16u) != 0u {
        let lasts = mask_index(tile, mask_words() - 1u, lane);
        masks[lasts] = insertBits(masks[lasts], visible >> 16u, row, 1u);
    }
}

// The bits of a row that stand for samples from `first` to `last`.
fn bits_between(row: u32, first: u32, last: u32) -> u32 {
    let low = select(0u, first % shape.columns, row == first / shape.columns);
    let high = select(31u, last % shape.columns, row == last / shape.columns);
    return (0xffffffffu << low) & (0xffffffffu >> (31u - high));
}

// The new samples of a row that a tree requests, of those from `first` to `last`.
fn requested_samples(tree: u32, row: u32, first: u32, last: u32) -> u32 {
    return requests[tree * shape.sample_rows + row] & new_samples(row) & bits_between(row, first, last);
}
