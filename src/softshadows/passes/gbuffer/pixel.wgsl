// How a pass that finds one light's visibility begins a pixel. The including file declares `light` and `visibility`.

//#needs light, visibility
//#include "receiver.wgsl"

// The pixel's receiver as the light sees it. Visibility is 1 where there is no surface, and then, as outside of the image,
// nothing is left to do.
fn begin_pixel(id: vec2u) -> Receiver {
    var receiver: Receiver;
    if any(id >= frame.size) {
        return receiver;
    }
    receiver = seen_by(light, load_receiver(id));
    receiver.index = visibility_index(light, id, frame.size);
    if !receiver.is_surface {
        visibility[receiver.index] = 1.0;
    }
    return receiver;
}
