// Triangles in the order of their codes: a radix sort, eight bits at a time from the lowest up, each pass stable.
//
//     cs_count         how often each digit stands in each block of triangles; a workgroup has one block
//     cs_scan_blocks   by digit: how often in the blocks before
//     cs_scan_digits   and how many smaller digits there are
//     cs_move          every triangle moves behind all that these sums count, and behind equal digits of its own block
//
// Workgroups hear of each other between dispatches only, so that it does not matter which of them run at one time.

//#include "lbvh_scratch.wgsl"
//#include "inclusive_scan.wgsl"
//#struct SortPass

@group(0) @binding(2) var<uniform> sort: SortPass;

const DIGITS = 256u;   // and invocations: each has a digit of its own
const WORDS = DIGITS / 32u;

fn block_count() -> u32 {
    return (tree.triangle_count + BLOCK - 1u) / BLOCK;
}

fn block_of(group: vec3u, groups: vec3u) -> u32 {
    return group.y * groups.x + group.x;
}

// From `order` to the other list in passes 0, 2 and 4, and back in the others.
fn triangle_from(index: u32) -> u32 {
    if sort.digit % 2u == 0u {
        return order[index];
    }
    return scratch[list_start() + index];
}

fn put(index: u32, triangle: u32) {
    if sort.digit % 2u == 0u {
        scratch[list_start() + index] = triangle;
    } else {
        order[index] = triangle;
    }
}

// A code is two words of three digits each.
fn digit_of(triangle: u32) -> u32 {
    return (scratch[code_at(triangle) + sort.digit / 3u] >> (8u * (sort.digit % 3u))) & (DIGITS - 1u);
}

// Where the count of a digit in a block lies; block_count() is that of the digit in all blocks.
fn count_at(digit: u32, block: u32) -> u32 {
    return counts_start() + digit * (block_count() + 1u) + block;
}

var<workgroup> counts: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(DIGITS)
fn cs_count(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = block_of(group, groups);
    atomicStore(&counts[lane], 0u);
    workgroupBarrier();
    let end = min(BLOCK * block + BLOCK, tree.triangle_count);
    for (var index = BLOCK * block + lane; index < end; index += DIGITS) {
        atomicAdd(&counts[digit_of(triangle_from(index))], 1u);
    }
    workgroupBarrier();
    if block < block_count() {
        scratch[count_at(lane, block)] = atomicLoad(&counts[lane]);
    }
}

@compute @workgroup_size(DIGITS)
fn cs_scan_blocks(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let digit = group.x;
    var before = 0u;
    for (var first = 0u; first < block_count(); first += DIGITS) {
        let block = first + lane;
        var count = 0u;
        if block < block_count() {
            count = scratch[count_at(digit, block)];
        }
        let sum = inclusive_scan(lane, count);
        if block < block_count() {
            scratch[count_at(digit, block)] = before + sum - count;
        }
        before += scan_total();
    }
    if lane == 0u {
        scratch[count_at(digit, block_count())] = before;
    }
}

@compute @workgroup_size(DIGITS)
fn cs_scan_digits(@builtin(local_invocation_index) lane: u32) {
    let count = scratch[count_at(lane, block_count())];
    scratch[count_at(lane, block_count())] = inclusive_scan(lane, count) - count;
}

// By digit: which lanes have it, a bit each, and where the next triangle that has it goes.
var<workgroup> lanes_with: array<atomic<u32>, DIGITS * WORDS>;
var<workgroup> next: array<u32, DIGITS>;

@compute @workgroup_size(DIGITS)
fn cs_move(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = min(block_of(group, groups), block_count());  // past the last one there is nothing to move
    next[lane] = scratch[count_at(lane, block_count())] + scratch[count_at(lane, block)];
    for (var word = 0u; word < WORDS; word++) {
        atomicStore(&lanes_with[WORDS * lane + word], 0u);
    }
    workgroupBarrier();
    for (var first = BLOCK * block; first < BLOCK * block + BLOCK; first += DIGITS) {
        let is_one = first + lane < tree.triangle_count;
        var triangle = 0u;
        var digit = 0u;
        if is_one {
            triangle = triangle_from(first + lane);
            digit = digit_of(triangle);
            atomicOr(&lanes_with[WORDS * digit + lane / 32u], 1u << (lane % 32u));
        }
        workgroupBarrier();
        if is_one {
            var place = next[digit];
            for (var word = 0u; word < lane / 32u; word++) {
                place += countOneBits(atomicLoad(&lanes_with[WORDS * digit + word]));
            }
            let lower = (1u << (lane % 32u)) - 1u;
            put(place + countOneBits(atomicLoad(&lanes_with[WORDS * digit + lane / 32u]) & lower), triangle);
        }
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            next[lane] += countOneBits(atomicExchange(&lanes_with[WORDS * lane + word], 0u));
        }
        workgroupBarrier();
    }
}
