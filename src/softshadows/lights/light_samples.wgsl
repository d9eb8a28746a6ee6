// A light and the points on it that stand for it: bindings 0, 1 and 4 of bind group 2.

//#include "receiver.wgsl"
//#struct LightSamples
//#struct Chunk

@group(2) @binding(0) var<storage, read> light: Light;
@group(2) @binding(1) var<storage, read> light_samples: LightSamples;
@group(2) @binding(4) var<uniform> chunk: Chunk;                       // those of one dispatch, whose maps the atlas holds
