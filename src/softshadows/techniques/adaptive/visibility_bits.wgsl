// Bits of a pixel's look-ups. The including file declares `visibility_bits`.

//#needs mask_index, mask_words, visibility_bits

// The samples of a row that the pixel sees.
fn row_bits(tile: u32, row: u32, lane: u32) -> u32 {
    let pair = visibility_bits[mask_index(tile, row / 2u, lane)];
    let lasts = visibility_bits[mask_index(tile, mask_words() - 1u, lane)];
    return extractBits(pair, 16u * (row % 2u), 16u) | (extractBits(lasts, row, 1u) << 16u);
}
