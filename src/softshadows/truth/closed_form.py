"""Exact visibility of set-ups simple enough to solve: the oracles O1 to O12 that check techniques and Embree alike.

Unless a function says otherwise, receiver, occluder and light lie in the parallel planes z = 0, z = h and z = H,
0 < h < H, with the light centred on the z axis. Seen from the receiver point x, an occluder point X appears on the
light's plane at

    u = x + (X − x) H/h,

magnified H/h times, and its picture moves by −(H − h)/h per unit of x.

All arguments are metres and broadcast; results are float64 in 0..1, 1 = fully lit. Angles are degrees. Coordinates are
those of the set-up, not of a scene: place them as you like, visibility does not change under motion or scaling.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Values = npt.ArrayLike


def projected(x: Values, X: Values, H: Values, h: Values) -> Array:
    """Where the occluder point `X` appears on the light's plane, seen from the receiver point `x` (one coordinate)."""
    x, X, H, h = _floats(x, X, H, h)
    return x + (X - x) * H / h


def half_plane(x: Values, H: Values, h: Values, a: Values, edge: Values) -> Array:
    """O1. Occluder X < `edge`; light of half width `a` along x: a rectangle parallel to the edge, or a line across it.

    V = clamp((a − u*) / 2a) with u* the projected edge: linear in x from 0 at x = (e H − a h)/(H − h) to 1 at
    (e H + a h)/(H − h), a penumbra 2 a h/(H − h) wide, which is also the width PCSS predicts.
    """
    (a,) = _floats(a)
    return np.clip((a - projected(x, edge, H, h)) / (2.0 * a), 0.0, 1.0)


def rotated_half_plane(
    x: Values, y: Values, H: Values, h: Values, a: Values, b: Values, angle: Values, edge: Values
) -> Array:
    """O2. Occluder X cos θ + Y sin θ < `edge`, light [−a, a] × [−b, b]: quadratic, linear, quadratic across the edge.

    The share of the light beyond a line at distance c from its centre is one minus the distribution function of a sum
    of two uniform variables, on ±A = ±a cos θ and ±B = ±b sin θ:

        F(c) = [(c + A + B)₊² − (c + A − B)₊² − (c − A + B)₊² + (c − A − B)₊²] / 8AB.
    """
    a, b, angle = _floats(a, b, np.radians(np.asarray(angle, np.float64)))
    x, y, edge = _floats(x, y, edge)
    c = projected(x * np.cos(angle) + y * np.sin(angle), edge, H, h)
    A, B = a * np.abs(np.cos(angle)), b * np.abs(np.sin(angle))
    wide, narrow = np.maximum(A, B), np.minimum(A, B)
    parallel = narrow < 1e-9 * wide  # the quadratic ends shrink to nothing, and the formula to 0/0
    divisor = np.where(parallel, 1.0, narrow)

    def square(distance: Array) -> Array:
        return np.maximum(distance, 0.0) ** 2

    below = (square(c + A + B) - square(c + A - B) - square(c - A + B) + square(c - A - B)) / (8.0 * wide * divisor)
    linear = (c + wide) / (2.0 * wide)
    return np.clip(1.0 - np.where(parallel, linear, below), 0.0, 1.0)


def half_plane_disk(x: Values, H: Values, h: Values, R: Values, edge: Values) -> Array:
    """O3. Occluder X < `edge`, disk light of radius `R`: V = (arccos t − t √(1 − t²)) / π with t = u*/R in [−1, 1]."""
    (R,) = _floats(R)
    t = np.clip(projected(x, edge, H, h) / R, -1.0, 1.0)
    return (np.arccos(t) - t * np.sqrt(1.0 - t * t)) / np.pi


def rectangle(
    x: Values, y: Values, H: Values, h: Values, a: Values, b: Values, occluder: tuple[float, float, float, float]
) -> Array:
    """O4. Occluder (x0, x1, y0, y1), axes aligned with the light [−a, a] × [−b, b].

    ψ = ox oy / 4ab: the product of what the projected intervals share with the light's.
    """
    return two_rectangles(x, y, H, a, b, (h, occluder), (h, (0.0, 0.0, 0.0, 0.0)))


def two_rectangles(
    x: Values,
    y: Values,
    H: Values,
    a: Values,
    b: Values,
    first: tuple[Values, tuple[float, float, float, float]],
    second: tuple[Values, tuple[float, float, float, float]],
) -> Array:
    """O5. Two occluders as in O4, each (height, (x0, x1, y0, y1)).

    ψ = ψ1 + ψ2 − overlap(rectangle 1 ∩ rectangle 2 ∩ light), whether they are disjoint, nested or crossing.
    """
    x, y, a, b = _floats(x, y, a, b)

    def on_light(occluder: tuple[Values, tuple[float, float, float, float]]) -> tuple[Array, Array, Array, Array]:
        height, (x0, x1, y0, y1) = occluder
        return (
            np.clip(projected(x, x0, H, height), -a, a),
            np.clip(projected(x, x1, H, height), -a, a),
            np.clip(projected(y, y0, H, height), -b, b),
            np.clip(projected(y, y1, H, height), -b, b),
        )

    def area(x0: Array, x1: Array, y0: Array, y1: Array) -> Array:
        return np.maximum(x1 - x0, 0.0) * np.maximum(y1 - y0, 0.0)

    p, q = on_light(first), on_light(second)
    shared = area(np.maximum(p[0], q[0]), np.minimum(p[1], q[1]), np.maximum(p[2], q[2]), np.minimum(p[3], q[3]))
    return 1.0 - (area(*p) + area(*q) - shared) / (4.0 * a * b)


def disk(distance: Values, H: Values, h: Values, R: Values, radius: Values) -> Array:
    """O6. Disk occluder of `radius` on the z axis, disk light of radius `R`; `distance` of the receiver from the axis.

    ψ = lens(R, ρ H/h, distance (H − h)/h) / πR²: the area that two circles share.
    """
    distance, H, h, R, radius = _floats(distance, H, h, R, radius)
    return 1.0 - circles_overlap(R, radius * H / h, np.abs(distance) * (H - h) / h) / (np.pi * R * R)


def circles_overlap(r1: Values, r2: Values, distance: Values) -> Array:
    """Area that two circles of radii `r1`, `r2` share, their centres `distance` apart."""
    r1, r2, distance = _floats(r1, r2, distance)
    apart = np.maximum(distance, 1e-300)
    cos1 = np.clip((apart**2 + r1**2 - r2**2) / (2.0 * apart * r1), -1.0, 1.0)
    cos2 = np.clip((apart**2 + r2**2 - r1**2) / (2.0 * apart * r2), -1.0, 1.0)
    kite = (-apart + r1 + r2) * (apart + r1 - r2) * (apart - r1 + r2) * (apart + r1 + r2)
    lens = r1**2 * np.arccos(cos1) + r2**2 * np.arccos(cos2) - 0.5 * np.sqrt(np.maximum(kite, 0.0))
    nested = distance <= np.abs(r1 - r2)
    return np.where(nested, np.pi * np.minimum(r1, r2) ** 2, np.where(distance >= r1 + r2, 0.0, lens))


def parallel_edge(x: Values, H: Values, h: Values, edge: Values, line: Values = 0.0) -> Array:
    """O7. Occluder X < `edge`, line light along y at x = `line`: a step, for all of it crosses the edge at once."""
    (line,) = _floats(line)
    return (projected(x, edge, H, h) < line).astype(np.float64)


def tilted_receiver(x2: Values, m: Values, t: Values, n: Values, s: Values, left: Values, right: Values) -> Array:
    """O8. In the plane: line light y = m x + t over x in [left, right], receiver y = n x + s at x = `x2`.

    The occluder is the half line y = 0, x < 0, between them (the receiver below 0, the light above).
    The light is seen right of x1 = x2 t / ((n − m) x2 + s): hyperbolic in x2, and linear only where m = n.
    """
    x2, m, t, n, s, left, right = _floats(x2, m, t, n, s, left, right)
    x1 = x2 * t / ((n - m) * x2 + s)
    return np.clip((right - x1) / (right - left), 0.0, 1.0)


def tilted_receiver_deviation(ratio: Values) -> Array:
    """O8. How far the penumbra departs from a linear ramp at most: |√r − 1| / (√r + 1).

    `ratio` r is that of the denominators (n − m) x2 + s at the two ends of the penumbra.
    """
    (ratio,) = _floats(ratio)
    return np.abs(np.sqrt(ratio) - 1.0) / (np.sqrt(ratio) + 1.0)


def strip(x: Values, H: Values, h: Values, a: Values, c: Values) -> Array:
    """O9. Occluder |X| < `c` across a line light along x of half length `a` (or a rectangle of that half width).

    Where c H/h < a there is no umbra: at x = 0 both ends of the light are seen and V = 1 − cH/(ah).
    """
    x, a, c = _floats(x, a, c)
    return 1.0 - slit(x, H, h, a, c)


def slit(x: Values, H: Values, h: Values, a: Values, g: Values) -> Array:
    """O10. Everything is blocked but |X| < `g`, light as in O9.

    At x = 0 and g H/h < a neither end of the light is seen, yet V = gH/(ah).
    """
    x, a, g = _floats(x, a, g)
    low, high = np.clip(projected(x, -g, H, h), -a, a), np.clip(projected(x, g, H, h), -a, a)
    return (high - low) / (2.0 * a)


def contact(x: Values, edge: Values) -> Array:
    """O11. The limit h → 0 of O1: an occluder X < `edge` that touches the receiver has a step for a penumbra."""
    x, edge = _floats(x, edge)
    return (x > edge).astype(np.float64)


def hard_shadow(x: Values, H: Values, h: Values, edge: Values) -> Array:
    """O12. Occluder X < `edge`, light of size zero at x = 0: the hard shadow of the light's centre, 0 or 1."""
    return parallel_edge(x, H, h, edge)


def _floats(*values: Any) -> tuple[Array, ...]:
    return tuple(np.asarray(value, np.float64) for value in values)
