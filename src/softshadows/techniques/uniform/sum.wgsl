// A pixel's visible weight, added up chunk by chunk. Weights are small whole numbers, so the sum is exact until it is divided.

//#include "lights/light_samples.wgsl"
//#include "passes/gbuffer/pixel.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;

// The end of the chunk's samples.
fn chunk_end() -> u32 {
    return chunk.first_sample + chunk.sample_count;
}

fn add_chunk(receiver: Receiver, visible_weight: f32) {
    let sum = visible_weight + select(visibility[receiver.index], 0.0, chunk.first_sample == 0u);
    visibility[receiver.index] = select(sum, sum / light_samples.total_weight, chunk_end() == light_samples.count);
}
