// A segment of the light in parts, one bit each: what the maps' rows show of it is gathered as bits.

// The first of `parts` parts whose middle does not lie before a share of the segment.
fn first_part(share: f32, parts: u32) -> i32 {
    return i32(ceil(clamp(share, 0.0, 1.0) * f32(parts) - 0.5));
}

// Bits `first` to `end` - 1 of 32, for any numbers.
fn bits_between(first: i32, end: i32) -> u32 {
    let low = clamp(first, 0, 32);
    let count = clamp(end, low, 32) - low;
    if count == 0 {
        return 0u;
    }
    return (0xffffffffu >> u32(32 - count)) << u32(low);
}
