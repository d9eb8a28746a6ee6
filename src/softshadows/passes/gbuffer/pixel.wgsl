// How a pass that finds one light's visibility begins a pixel. The including file declares `visibility`.

struct SurfacePixel {
    is_surface: bool,         // false also outside of the image: nothing is left to do
    index: u32,               // in the visibility
    surface: Receiver,
};

// Visibility is 1 where there is no surface.
fn begin_surface(id: vec2u) -> SurfacePixel {
    var pixel: SurfacePixel;
    if any(id >= frame.size) {
        return pixel;
    }
    pixel.index = visibility_index(light, id, frame.size);
    pixel.surface = load_receiver(id);
    pixel.is_surface = pixel.surface.is_surface;
    if !pixel.is_surface {
        visibility[pixel.index] = 1.0;
    }
    return pixel;
}

struct Pixel {
    is_surface: bool,
    index: u32,
    receiver: LightReceiver,
};

// Visibility is 1 everywhere, until something is found.
fn begin_pixel(id: vec2u) -> Pixel {
    let found = begin_surface(id);
    var pixel = Pixel(found.is_surface, found.index, LightReceiver());
    if found.is_surface {
        visibility[found.index] = 1.0;
        pixel.receiver = light_receiver(found.surface.position_ws, found.surface.normal_ws);
    }
    return pixel;
}
