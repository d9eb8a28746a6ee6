"""Shadow maps in one atlas: planned, fitted on the GPU, drawn at once, looked up."""
