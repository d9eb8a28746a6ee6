// What the kernels of a light share: the samples in use, and the arguments of what follows.

//#struct Control

// The sample of the set before `sample`, or `sample` itself.
fn sample_before(samples: u32, sample: u32) -> u32 {
    let before = samples & ((1u << sample) - 1u);
    return select(firstLeadingBit(before), sample, before == 0u);
}

// The sample of the set after it, or `sample` itself.
fn sample_after(samples: u32, sample: u32) -> u32 {
    let after = samples & ~((2u << sample) - 1u);
    return select(firstTrailingBit(after), sample, after == 0u);
}
