// A tree of boxes over the scene's triangles, walked without a stack: nodes lie in preorder, so that where a box is met the
// next node follows, and where it is not, its escape index follows, past its tree (bvh.py).
//
// A node is four words: its box on a grid over the scene, low and high corner in the low and high 16 bits of x, y and z, and
// its link. An inner node's link is the node that follows its tree. A leaf's has the highest bit set, three bits for the number
// of its triangles less one, and 28 for the first one's place.

//#struct TreeGrid

const LEAF = 0x80000000u;
const LEAF_COUNT_SHIFT = 28u;
const LEAF_COUNT_MASK = 7u;
const LEAF_FIRST_MASK = 0x0fffffffu;

fn box_low(box: vec4u) -> vec3f {
    return vec3f(box.xyz & vec3u(0xffffu));
}

fn box_high(box: vec4u) -> vec3f {
    return vec3f(box.xyz >> vec3u(16u));
}

fn leaf_first(leaf: vec4u) -> u32 {
    return leaf.w & LEAF_FIRST_MASK;
}

fn leaf_end(leaf: vec4u) -> u32 {
    return leaf_first(leaf) + ((leaf.w >> LEAF_COUNT_SHIFT) & LEAF_COUNT_MASK) + 1u;
}
