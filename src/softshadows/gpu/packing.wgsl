// How the G-buffer's material texture packs its values.

const RGB9E5_MANTISSA_BITS = 9;
const RGB9E5_EXPONENT_BIAS = 15;
const RGB9E5_MAX = 65408.0;  // (2⁹ - 1) / 2⁹ · 2³¹⁻¹⁵
const RGB9E5_MAX_MANTISSA = 511.0;

fn sign_not_zero(v: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

// A unit vector as two snorm16, octahedral: Cigolle et al., "A Survey of Efficient Representations for Independent Unit
// Vectors", JCGT 3(2), 2014. Largest error 0.005°. A zero vector becomes +z.
fn pack_normal(normal: vec3f) -> u32 {
    let manhattan = abs(normal.x) + abs(normal.y) + abs(normal.z);
    let flat = normal.xy / max(manhattan, 1e-30);
    return pack2x16snorm(select((1.0 - abs(flat.yx)) * sign_not_zero(flat), flat, normal.z >= 0.0));
}

fn unpack_normal(bits: u32) -> vec3f {
    let flat = unpack2x16snorm(bits);
    let z = 1.0 - abs(flat.x) - abs(flat.y);
    let fold = max(-z, 0.0);
    return normalize(vec3f(flat - fold * sign_not_zero(flat), z));
}

// Three non-negative floats with 9 bits each and one exponent, as the format rgb9e5ufloat: error 2⁻¹⁰ of the largest,
// which is 65408 at most. Khronos, EXT_texture_shared_exponent.
fn pack_rgb9e5(color: vec3f) -> u32 {
    let clamped = clamp(color, vec3f(0.0), vec3f(RGB9E5_MAX));
    let largest = max(clamped.r, max(clamped.g, clamped.b));
    let floor_log2 = i32(bitcast<u32>(largest) >> 23u) - 127;  // the float's own exponent
    var exponent = max(floor_log2 + 1 + RGB9E5_EXPONENT_BIAS, 0);
    if round(largest * rgb9e5_scale(exponent)) > RGB9E5_MAX_MANTISSA {
        exponent += 1;  // rounding up reached 2⁹
    }
    let mantissa = vec3u(round(clamped * rgb9e5_scale(exponent)));
    return mantissa.r | (mantissa.g << 9u) | (mantissa.b << 18u) | (u32(exponent) << 27u);
}

// What a value is multiplied by to become its mantissa.
fn rgb9e5_scale(exponent: i32) -> f32 {
    let power = RGB9E5_MANTISSA_BITS + RGB9E5_EXPONENT_BIAS - exponent;
    return bitcast<f32>(u32(power + 127) << 23u);  // 2^power, exact
}

fn unpack_rgb9e5(bits: u32) -> vec3f {
    let mantissa = vec3u(bits, bits >> 9u, bits >> 18u) & vec3u(0x1ffu);
    return vec3f(mantissa) / rgb9e5_scale(i32(bits >> 27u));
}

// The sRGB transfer functions, IEC 61966-2-1; both for values in 0..1.
fn linear_to_srgb(linear: vec3f) -> vec3f {
    let curve = 1.055 * pow(max(linear, vec3f(0.0)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3f(0.0031308));
}

fn srgb_to_linear(encoded: vec3f) -> vec3f {
    let curve = pow(max((encoded + 0.055) / 1.055, vec3f(0.0)), vec3f(2.4));
    return select(curve, encoded / 12.92, encoded <= vec3f(0.04045));
}
