// One walk of the tree for all samples of a light: each box asks whether it could hide a sample that is not hidden yet, each
// triangle marks what it hides. The light is a rectangle, or a line where line.wgsl stands in for it.

//#include "rectangle.wgsl"
//#include "cutouts.wgsl"

@group(1) @binding(2) var<storage, read> tree_nodes: array<vec4u>;
@group(1) @binding(3) var<storage, read> tree_triangles: array<vec4f>;  // three corners each, light space; number in the first's w

override is_stratified = false;  // every pixel of a block of 4×4 moves the samples elsewhere

// Orthogonal Latin squares by pixel of a block: the quarter of a cell, across and up, that its samples lie in (lights/jitter.py).
const QUARTERS_ACROSS = vec4u(0x3120u, 0x1302u, 0x2031u, 0x0213u);
const QUARTERS_UP = vec4u(0x3120u, 0x2031u, 0x0213u, 0x1302u);

fn shift_of(pixel: vec2u) -> vec2f {
    if !is_stratified {
        return row_set.shift;
    }
    let place = 4u * (pixel.x % 4u);
    let across = f32((QUARTERS_ACROSS[pixel.y % 4u] >> place) & 3u);
    let up = f32((QUARTERS_UP[pixel.y % 4u] >> place) & 3u);
    let share = (vec2f(4.0 * across + up, 4.0 * up + across) + 0.5) / 16.0 - 0.5;
    return row_set.shift + share * vec2f(1.0, 1.0 - row_set.slant);
}

// A triangle's corners, from the receiver.
struct Corners {
    a: vec3f,
    b: vec3f,
    c: vec3f,
};

fn corners_from(view: View, a_ls: vec3f, b_ls: vec3f, c_ls: vec3f) -> Corners {
    return Corners(corner_from(view, a_ls), corner_from(view, b_ls), corner_from(view, c_ls));
}

// The far side of a solid is enough: its near side hides no more, and a receiver on it would meet its own surface. A triangle
// without a plane hides nothing. Loops pass over what a triangle has no use for (gpu/driver.wgsl).
fn mark_triangle(view: View, place: u32) {
    triangles_met++;
    let first = tree_triangles[3u * place];
    let corners = corners_from(view, first.xyz, tree_triangles[3u * place + 1u].xyz, tree_triangles[3u * place + 2u].xyz);
    let triangle = bitcast<u32>(first.w);
    let is_degenerate = all(cross(corners.c - corners.a, corners.a - corners.b) == vec3f(0.0));
    let is_near_side = triangle < view.solid_count && volume_of(view, corners) <= 0.0;
    let is_marking = !is_degenerate && !is_near_side;
    let lowest = min(corners.a.z, min(corners.b.z, corners.c.z));
    let highest = max(corners.a.z, max(corners.b.z, corners.c.z));
    let is_between = lowest > view.nearest && highest < view.height - view.nearest;

    let picture = picture_of(view, corners);
    for (var word = picture.first; is_marking && is_between && word <= picture.last; word += 1.0) {
        words_marked++;
        mark(word, bits_in_picture(view, picture, word));
    }
    for (var is_beyond = is_marking && !is_between; is_beyond; is_beyond = false) {
        let planes = planes_of(view, corners);
        for (var word = 0.0; word <= view.last_word; word += 1.0) {
            words_marked++;
            mark(word, bits_behind_planes(planes, word));
        }
    }
    hide_marked(view, corners, triangle);
}

// How much this invocation has met, for those who count it; elsewhere a compiler drops it.
var<private> boxes_met: u32;
var<private> triangles_met: u32;
var<private> words_marked: u32;

const NO_LEAF = vec4u(0u);

// [Laine2005 shaft] Mark all samples that a triangle hides. Boxes stand in the inner loop and triangles in the outer one (gpu/driver.wgsl).
// False where the walk was cut short.
fn mark_hidden(view: View) -> bool {
    let count = light_tree.node_count;
    var node = 0u;
    var is_walking = count > 0u && !are_all_hidden();
    while is_walking {
        // Two leaves before their triangles: neighbours, which run in step, wait less for each other.
        var earlier = NO_LEAF;
        var leaf = NO_LEAF;
        while earlier.w == 0u && node < count {
            boxes_met++;
            let box = tree_nodes[node];
            let is_met = may_hide(view, box);
            let is_leaf = box.w >= LEAF;
            earlier = select(earlier, leaf, is_met && is_leaf);
            leaf = select(leaf, box, is_met && is_leaf);
            node = select(box.w, node + 1u, is_met || is_leaf);
        }
        var place = leaf_first(earlier);
        var end = select(0u, leaf_end(earlier), earlier.w != 0u);
        while place < end || leaf.w != 0u {
            let is_next = place == end;
            place = select(place, leaf_first(leaf), is_next);
            end = select(end, leaf_end(leaf), is_next);
            leaf = select(leaf, NO_LEAF, is_next);
            mark_triangle(view, place);
            place++;
        }
        is_walking = node < count && !are_all_hidden();
    }
    return !is_walking;
}

// Which samples does the receiver see? Those whose bits are not set afterwards. False where the walk was cut short.
fn walk(receiver: Receiver, pixel: vec2u) -> bool {
    let seen = seen_by(light, receiver);
    let view = view_of(lifted(seen), shift_of(pixel));
    begin_hidden();
    hide_below_horizon(view);
    if !is_on_emitting_side(light, seen) {
        hide_all();
    }
    return mark_hidden(view);
}
