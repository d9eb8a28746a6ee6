// For scenes without alpha masks, in place of cutouts.wgsl: surfaces exist wherever their triangles are.

//#needs Corners, View, hide

fn mark(word: f32, bits: u32) {
    hide(word, bits);
}

fn hide_marked(view: View, corners: Corners, triangle: u32) {}
