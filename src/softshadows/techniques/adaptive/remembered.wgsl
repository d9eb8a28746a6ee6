// What a pixel remembers of its look-ups. The including file declares `masks`.

//#needs mask_index, mask_words, masks

// The samples of a row that the pixel sees.
fn remembered(tile: u32, row: u32, lane: u32) -> u32 {
    let pair = masks[mask_index(tile, row / 2u, lane)];
    let lasts = masks[mask_index(tile, mask_words() - 1u, lane)];
    return extractBits(pair, 16u * (row % 2u), 16u) | (extractBits(lasts, row, 1u) << 16u);
}
