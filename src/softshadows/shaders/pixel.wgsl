// How a pass that finds one light's visibility begins a pixel. The including file declares `visibility`.

struct Pixel {
    is_surface: bool,         // false also outside of the image: nothing is left to do
    index: u32,               // in the visibility
    receiver: LightReceiver,
};

// Visibility is 1 until something is found, and stays so where there is no surface.
fn begin_pixel(id: vec2u) -> Pixel {
    var pixel: Pixel;
    if any(id >= frame.size) {
        return pixel;
    }
    pixel.index = light.visibility_offset + id.y * frame.size.x + id.x;
    visibility[pixel.index] = 1.0;
    let surface = load_receiver(id);
    if surface.is_surface {
        pixel.is_surface = true;
        pixel.receiver = light_receiver(surface.position_ws, surface.normal_ws);
    }
    return pixel;
}
