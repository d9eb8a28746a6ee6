// The mean of frames that show the same, each with other samples of its lights, put in the place of the last of them.

//#struct MeanStep

@group(0) @binding(0) var<storage, read> step: MeanStep;
@group(0) @binding(1) var<storage, read_write> visibility: array<f32>;  // [light][y][x]: the last frame's, then the mean
@group(0) @binding(2) var<storage, read_write> mean_visibility: array<f32>;
@group(0) @binding(3) var<storage, read_write> mean_color: array<vec4f>;
@group(0) @binding(4) var color: texture_2d<f32>;  // the last frame's
@group(0) @binding(5) var shown_color: texture_storage_2d<rgba32float, write>;  // the same image

// mₙ = mₙ₋₁ + (x - mₙ₋₁) / n: what does not change stays as it is to the last bit.

@compute @workgroup_size(8, 8)
fn cs_average(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= step.size) {
        return;
    }
    let is_first = step.frames == 1u;
    let weight = 1.0 / f32(step.frames);
    let pixel = id.y * step.size.x + id.x;
    for (var layer = 0u; layer < step.light_count; layer++) {
        let index = layer * step.size.x * step.size.y + pixel;
        let earlier = select(mean_visibility[index], visibility[index], is_first);
        let mean = earlier + (visibility[index] - earlier) * weight;
        mean_visibility[index] = mean;
        visibility[index] = mean;
    }
    let radiance = textureLoad(color, id.xy, 0);
    let earlier = select(mean_color[pixel], radiance, is_first);
    mean_color[pixel] = earlier + (radiance - earlier) * weight;
}

@compute @workgroup_size(8, 8)
fn cs_show(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < step.size) {
        textureStore(shown_color, id.xy, mean_color[id.y * step.size.x + id.x]);
    }
}
