// The samples of the light that are known to be hidden, a bit each: eight words of 32, four in a vector (lights/rows.py).

//#struct RowSet

override has_upper_words = true;  // words 4 to 7; without them, four are all

@group(1) @binding(4) var<storage, read> row_set: RowSet;

const COLUMNS = 32.0;
const LOWER_WORDS = vec4f(0.0, 1.0, 2.0, 3.0);
const UPPER_WORDS = vec4f(4.0, 5.0, 6.0, 7.0);
const ALL = vec4u(0xffffffffu);
const NONE = vec4u(0u);
const UNIT = 8388608.0;  // 2^23: float32 has no fractions from here on

var<private> hidden_lower: vec4u;
var<private> hidden_upper: vec4u;

// Samples that do not lie on the light hide nothing that counts.
fn begin_hidden() {
    hidden_lower = row_set.outside_lower;
    hidden_upper = row_set.outside_upper;
}

fn hide_all() {
    hidden_lower = ALL;
    hidden_upper = ALL;
}

// The bits where one of four words is `word`. Words are counted in float32, as rows are.
fn bits_at(words: vec4f, word: f32, bits: u32) -> vec4u {
    return select(NONE, vec4u(bits), words == vec4f(word));
}

// Hide samples of one word.
fn hide(word: f32, bits: u32) {
    hidden_lower |= bits_at(LOWER_WORDS, word, bits);
    if has_upper_words {
        hidden_upper |= bits_at(UPPER_WORDS, word, bits);
    }
}

// The bits of samples at or right of a place along the row, sample c being at c + ½. Two intervals that meet in one number
// share no bit and leave none out.
fn bits_from(place: vec4f) -> vec4u {
    // The nearest whole number, which stands in the lowest bits of the sum.
    let first = bitcast<vec4u>(clamp(place, vec4f(0.0), vec4f(COLUMNS)) + UNIT) & vec4u(63u);
    return select(ALL << (first & vec4u(31u)), NONE, first >= vec4u(32u));
}

// [Schwarz2007 bit mask]
fn bits_between(left: vec4f, right: vec4f) -> vec4u {
    return bits_from(left) & ~bits_from(right);
}

// The same of one word.
fn word_between(left: f32, right: f32) -> u32 {
    return bits_between(vec4f(left), vec4f(right)).x;
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
