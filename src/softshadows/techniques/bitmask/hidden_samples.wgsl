// The samples of the light that are known to be hidden, a bit each: eight words of 32, four in a vector (lights/rows.py). Written
// out, since loops over them would use up the rounds that drivers grant (gpu/driver.wgsl).

//#struct RowSet

override has_upper_words = true;  // words 4 to 7; without them, four are all

@group(1) @binding(4) var<storage, read> row_set: RowSet;

const COLUMNS = 32.0;
const LOWER_ROWS = vec4f(0.0, 1.0, 2.0, 3.0);
const UPPER_ROWS = vec4f(4.0, 5.0, 6.0, 7.0);
const ALL = vec4u(0xffffffffu);

var<private> hidden_lower: vec4u;
var<private> hidden_upper: vec4u;

// Samples of all words: those that a triangle hides, before they join the hidden ones.
struct Marks {
    lower: vec4u,
    upper: vec4u,
};

fn hide(marks: Marks) {
    hidden_lower |= marks.lower;
    hidden_upper |= marks.upper;
}

// Samples that do not lie on the light hide nothing that counts.
fn begin_hidden() {
    hidden_lower = row_set.outside_lower;
    hidden_upper = row_set.outside_upper;
}

// The bits of samples at or right of a place along the row, sample c being at c + ½. Two intervals that meet in one number
// share no bit and leave none out.
fn bits_from(place: vec4f) -> vec4u {
    let first = vec4u(round(clamp(place, vec4f(0.0), vec4f(COLUMNS))));
    return select(ALL << (first & vec4u(31u)), vec4u(0u), first >= vec4u(32u));
}

// [Schwarz2007 bit mask]
fn bits_between(left: vec4f, right: vec4f) -> vec4u {
    return bits_from(left) & ~bits_from(right);
}

fn are_all_hidden() -> bool {
    var bits = hidden_lower;
    if has_upper_words {
        bits &= hidden_upper;
    }
    return all(bits == ALL);
}

// How many samples are not hidden.
fn visible_count() -> u32 {
    var count = countOneBits(~hidden_lower);
    if has_upper_words {
        count += countOneBits(~hidden_upper);
    }
    return count.x + count.y + count.z + count.w;
}
