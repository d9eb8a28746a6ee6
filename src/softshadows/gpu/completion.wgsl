// Writes the frame's number after its results: the last thing a frame does on the GPU (see readback.py).

@group(0) @binding(0) var<uniform> frame_number: vec4u;
@group(0) @binding(1) var<storage, read_write> completion_word: vec4u;

@compute @workgroup_size(1)
fn cs_complete() {
    completion_word = frame_number;
}
