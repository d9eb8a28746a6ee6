// A tree of boxes over the scene's triangles, without a stack: nodes lie in preorder, so that the way through the tree is the
// next node where a box is met, and past its tree where it is not (bvh.py).
//
// A node is four words: its box on a grid over the scene, low and high corner in the low and high 16 bits of x, y and z, and
// its link. An inner node's link is the node that follows its tree. A leaf's is its first triangle, how many it has less one,
// and the highest bit.

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
