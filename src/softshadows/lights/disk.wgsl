// Disks: exact diffuse irradiance by Lambert's boundary integral along the circle; a highlight that is that of a 16-gon of the
// disk's area.

//#include "area_light.wgsl"
//#include "polygon.wgsl"

const DISK_CORNERS = 16u;
const DISK_CORNER_RADIUS = 1.01300156;  // sqrt(2π / (16 sin(2π / 16))): the 16-gon has the disk's area

// atan(x) / x, to more digits than WGSL asks of atan
fn arctangent_ratio(x: f32) -> f32 {
    let cosine = inverseSqrt(1.0 + x * x);
    return cosine * (1.0 + angle_excess(cosine, abs(x) * cosine));
}

// log(1 + y) / y, for small y by the series of 2 artanh(y / (2 + y))
fn logarithm_ratio(y: f32) -> f32 {
    let z = y / (2.0 + y);
    let series = 1.0 + z * z * (1.0 / 3.0 + z * z * (1.0 / 5.0 + z * z * (1.0 / 7.0 + z * z / 9.0)));
    return select(log(1.0 + y) / y, 2.0 / (2.0 + y) * series, abs(z) < 0.15);
}

// Lambert's boundary integral ½ ∮ (r × dr)_z / r² along r = center + right cos ψ + up sin ψ; right and up are as long
// as the radius. With up turned square to the centre, r² = P + Q cos ψ and (r × dr)_z = (A + B cos ψ + C sin ψ) dψ.
fn disk_irradiance(light: Light, position_ws: vec3f, to_surface: mat3x3f) -> f32 {
    let disk = seen_light(light, position_ws, to_surface);
    let center = disk.center;
    let right = disk.right;
    let up = disk.up;
    let radius = length(right);
    if radius * radius < TINY {
        return 0.0;
    }
    let aside = vec2f(dot(center, right), dot(center, up));
    let aside_length = length(aside);
    // Turn the axes so that `outward` points away from the foot of the perpendicular from the origin.
    let turn = select(vec2f(1.0, 0.0), aside / aside_length, aside_length > TINY);
    let outward = turn.x * right + turn.y * up;
    let across = turn.x * up - turn.y * right;

    let offset = aside_length / radius;
    let height = dot(center, cross(right, up)) / (radius * radius);
    let far_squared = height * height + (offset + radius) * (offset + radius);   // P + Q
    let near_squared = height * height + (offset - radius) * (offset - radius);  // P - Q
    let p = 0.5 * (far_squared + near_squared);
    let q = 2.0 * aside_length;
    let s = max(sqrt(far_squared * near_squared), TINY);  // sqrt(P² - Q²)
    let a = cross(outward, across).z;
    let b = cross(center, across).z;
    let c = -cross(center, outward).z;
    let per_angle = a / s - b * q / (s * (s + p));

    // A disk wholly above the horizon has its whole circle for an outline.
    let drop = length(vec2f(outward.z, across.z));
    if center.z >= drop {
        return abs(PI * per_angle);
    }
    if center.z <= -drop {
        return 0.0;
    }

    // Otherwise the outline is an arc and the chord that the horizon cuts.
    let uphill = vec2f(outward.z, across.z) / drop;
    let toward = -center.z / drop;  // cosine of half the arc
    let aslant = sqrt((1.0 - toward) * (1.0 + toward));
    let half_arc = aslant * (1.0 + angle_excess(toward, aslant));
    let start = toward * uphill + aslant * vec2f(uphill.y, -uphill.x);
    let end = toward * uphill + aslant * vec2f(-uphill.y, uphill.x);
    let eccentricity = q / (p + s);
    let odd = disk_arc_term(end, eccentricity) - disk_arc_term(start, eccentricity);
    let start_squared = p + q * start.x;
    let rise = (end.x - start.x) / start_squared;
    let arc = 2.0 * half_arc * per_angle + odd * (2.0 * b * p / (s * (p + s)) - 2.0 * a * eccentricity / s)
        - c * rise * logarithm_ratio(q * rise);
    let start_point = center + start.x * outward + start.y * across;
    let end_point = center + end.x * outward + end.y * across;
    return abs(0.5 * arc + edge_irradiance(vec3f(end_point.xy, 0.0), vec3f(start_point.xy, 0.0)));
}

// atan(e sin ψ / (1 + e cos ψ)) / e for direction (cos ψ, sin ψ): ∫ dψ / (P + Q cos ψ) = ψ / S - 2 e / S times this.
fn disk_arc_term(direction: vec2f, eccentricity: f32) -> f32 {
    let slope = direction.y / (1.0 + eccentricity * direction.x);
    return slope * arctangent_ratio(eccentricity * slope);
}

fn disk_corner(disk: SeenLight, index: u32) -> vec3f {
    let angle = 2.0 * PI * f32(index % DISK_CORNERS) / f32(DISK_CORNERS);
    return disk.center + DISK_CORNER_RADIUS * (cos(angle) * disk.right + sin(angle) * disk.up);
}

fn disk_specular(light: Light, surface: Surface, lobes: Lobes) -> vec3f {
    let disk = seen_light(light, surface.position_ws, lobes.to_surface);
    var outline = LobeOutline();
    var corner = disk_corner(disk, 0u);
    for (var i = 1u; i <= DISK_CORNERS; i++) {
        let next = disk_corner(disk, i);
        add_lobe_edge(&outline, lobes.to_lobe, corner, next);
        corner = next;
    }
    return lobe_reflection(abs(close_lobe_outline(outline, lobes.to_lobe)), lobes);
}
