// Which row of workgroups works on which row of the image, where pixels take unlike time.
//
// llvmpipe hands each processor one contiguous share of a dispatch's workgroups, so that the quiet half of an image would leave
// one of them idle. A GPU takes workgroups as it comes free; neighbours in x stay neighbours there.

const INTERLEAVED = 16u;

// A permutation of the rows of a dispatch, which are a multiple of INTERLEAVED (budget.py): any share of consecutive ones is spread
// over the image. The last rows may lie outside of it.
fn interleaved_row(row: u32, rows: u32) -> u32 {
    let sweep = rows / INTERLEAVED;
    return INTERLEAVED * (row % sweep) + (reverseBits(row / sweep) >> 28u);
}
