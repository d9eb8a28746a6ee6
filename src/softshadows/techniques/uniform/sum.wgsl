// A pixel's visible weight, added up chunk by chunk. Weights are small whole numbers, so the sum is exact until it is divided.

//#include "receiver.wgsl"
//#include "light_samples.wgsl"

@group(3) @binding(0) var<storage, read_write> visibility: array<f32>;

struct SummedPixel {
    is_surface: bool,   // false also outside of the image: nothing is left to do
    index: u32,         // in the visibility
    surface: Receiver,
};

fn begin_sum(id: vec2u) -> SummedPixel {
    var pixel: SummedPixel;
    if any(id >= frame.size) {
        return pixel;
    }
    pixel.index = light.visibility_offset + id.y * frame.size.x + id.x;
    pixel.surface = load_receiver(id);
    pixel.is_surface = pixel.surface.is_surface;
    if !pixel.is_surface {
        visibility[pixel.index] = 1.0;
    }
    return pixel;
}

// The end of the chunk's samples.
fn chunk_end() -> u32 {
    return chunk.first_sample + chunk.sample_count;
}

fn add_chunk(pixel: SummedPixel, visible_weight: f32) {
    let sum = visible_weight + select(visibility[pixel.index], 0.0, chunk.first_sample == 0u);
    visibility[pixel.index] = select(sum, sum / light.total_weight, chunk_end() == light.sample_count);
}
