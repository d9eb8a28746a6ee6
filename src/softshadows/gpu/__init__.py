"""The GPU layer: device, shared structs, WGSL composition, scene upload, timing and the one read-back."""
