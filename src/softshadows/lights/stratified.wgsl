// Where on the light a pixel looks at a sample: where all pixels do, or at a place that no other pixel of its block looks at
// (jitter.py). Places follow each other in light_samples, each with all samples.

//#include "light_samples.wgsl"

const BLOCK = 4u;  // pixels along its side

fn light_sample_for(pixel: vec2u, sample: u32) -> vec2f {
    let places = arrayLength(&light_samples.points) / light_samples.count;
    let place = select(0u, pixel.y % BLOCK * BLOCK + pixel.x % BLOCK, places > 1u);
    return light_samples.points[place * light_samples.count + sample].xy;
}
