"""Fit the table of linearly transformed cosines that area-light specular shading reads.

    python benchmarks/fit_ltc.py [--size 64] [--out src/softshadows/lights/ltc.npy]

The lobe ρ(ω_v, ω_l) cos θ_l of a GGX surface (Smith masking, height-correlated; Fresnel left out) is approximated by a
linearly transformed cosine, Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly
Transformed Cosines", SIGGRAPH 2016, equations 1 and 4. The fit is our own: all entries of one roughness are solved
together by Levenberg-Marquardt on the squared difference, and the transformed cosine is cut off at the surface's
horizon and scaled back to its full integral, which the shader repeats. So no light is lost below the horizon.

The table is (size, size, 6) float32, [view, roughness, entry]:
    row i      sqrt(1 - cos θ_v) = i / (size - 1)
    column j   roughness = MIN_ROUGHNESS + (1 - MIN_ROUGHNESS) j / (size - 1), and α = roughness²
    entries    a, b, c, d of the inverse matrix [[a 0 b] [0 1 0] [c 0 d]] in the frame (tangent towards the viewer,
               bitangent, normal); then the albedo for Fresnel 1, then for Fresnel (1 - v·h)⁵.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

MIN_ROUGHNESS = 0.045
"""The smoothest entry, as in surface.wgsl: the limit for float32 in Filament's documentation, section 4.8.3.3."""
MIN_COSINE = 1e-3
"""cos θ_v of the grazing row: at zero the lobe has no limit that a table could hold."""
TABLE = Path(__file__).parent.parent / "src/softshadows/lights/ltc.npy"


def smith_lambda(cosine: Array, alpha: float) -> Array:
    tangent_squared = 1.0 / np.maximum(cosine, 1e-9) ** 2 - 1.0
    return 0.5 * (np.sqrt(1.0 + alpha**2 * tangent_squared) - 1.0)


def ggx_distribution(cosine: Array, alpha: float) -> Array:
    return alpha**2 / (np.pi * (cosine**2 * (alpha**2 - 1.0) + 1.0) ** 2)


def lobe_and_density(view: Array, light: Array, alpha: float) -> tuple[Array, Array]:
    """ρ cos θ_l without Fresnel, and the density with which `sample_lobe` draws `light`; both (views, points)."""
    view = view[:, None, :]
    half = view + light
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    view_lambda, light_lambda = smith_lambda(view[..., 2], alpha), smith_lambda(light[..., 2], alpha)
    peak = ggx_distribution(half[..., 2], alpha) / (4.0 * view[..., 2])
    above = light[..., 2] > 0.0
    return peak / (1.0 + view_lambda + light_lambda) * above, peak / (1.0 + view_lambda)


def sample_lobe(view: Array, uniform: Array, alpha: float) -> Array:
    """Reflections, (views, points, 3), about normals visible from `view` (Heitz, JCGT 7(4), 2018); some are below."""
    stretched = view * (alpha, alpha, 1.0)
    stretched /= np.linalg.norm(stretched, axis=-1, keepdims=True)
    across = np.array([0.0, 1.0, 0.0])  # `view` lies in the xz plane
    along = np.cross(stretched, across)
    radius, angle = np.sqrt(uniform[:, 0]), 2.0 * np.pi * uniform[:, 1]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    tilt = 0.5 * (1.0 + stretched[:, 2:])
    x = (1.0 - tilt) * np.sqrt(1.0 - y**2) + tilt * x
    z = np.sqrt(np.maximum(0.0, 1.0 - x**2 - y**2))
    normal = x[..., None] * along[:, None] + y[:, None] * across + z[..., None] * stretched[:, None]
    normal *= (alpha, alpha, 1.0)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    view = view[:, None]
    return 2.0 * np.sum(view * normal, axis=-1, keepdims=True) * normal - view


def grid(rows: int, columns: int) -> Array:
    """Midpoints of the unit square, (rows × columns, 2)."""
    u, v = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij")
    return np.stack([u.ravel(), v.ravel()], axis=-1)


def albedos(view: Array, alpha: float) -> Array:
    """(views, 2): the integral of ρ cos θ_l for Fresnel 1 and for Fresnel (1 - v·h)⁵."""
    light = sample_lobe(view, grid(256, 64), alpha)
    above = light[..., 2] > 0.0
    half = view[:, None] + light
    cosine = np.sum(view[:, None] * half, axis=-1) / np.linalg.norm(half, axis=-1)
    view_lambda, light_lambda = smith_lambda(view[:, None, 2], alpha), smith_lambda(light[..., 2], alpha)
    ratio = (1.0 + view_lambda) / (1.0 + view_lambda + light_lambda) * above
    return np.stack([ratio.mean(axis=-1), (ratio * (1.0 - cosine) ** 5).mean(axis=-1)], axis=-1)


def inverse_matrix(parameters: Array) -> Array:
    """Entries a, b, c, d, (views, 4), of the inverse of M = rotation(tilt) · [[x 0 s] [0 y 0] [0 0 1]], times y."""
    tilt, x, y, shear = parameters[:, 0], np.exp(parameters[:, 1]), np.exp(parameters[:, 2]), parameters[:, 3]
    sine, cosine = np.sin(tilt), np.cos(tilt)
    return np.stack([y / x * (cosine - shear * sine), -y / x * (sine + shear * cosine), y * sine, y * cosine], axis=-1)


def transformed_cosine(matrix: Array, light: Array) -> Array:
    """The distribution at `light` (views, points, 3), cut at the horizon and scaled to integrate to one above it."""
    a, b, c, d = matrix.T[:, :, None]
    x, y, z = a * light[..., 0] + b * light[..., 2], light[..., 1], c * light[..., 0] + d * light[..., 2]
    determinant = a * d - b * c
    density = determinant * np.maximum(z, 0.0) / (np.pi * (x**2 + y**2 + z**2) ** 2)
    return density / (0.5 + 0.5 * a / np.hypot(a, c))


def fit(view: Array, alpha: float, albedo: Array, parameters: Array, steps: int = 60) -> tuple[Array, Array]:
    """Best parameters (views, 4) from a first guess, and the root of the summed squared difference, both per view."""
    drawn = sample_lobe(view, grid(24, 48), alpha)
    hemisphere = grid(12, 24)
    height, angle = hemisphere[:, 0], 2.0 * np.pi * hemisphere[:, 1]
    side = np.sqrt(1.0 - height**2)
    even = np.broadcast_to(
        np.stack([side * np.cos(angle), side * np.sin(angle), height], axis=-1), (len(view), len(height), 3)
    )
    light = np.concatenate([drawn, even], axis=1)
    lobe, density = lobe_and_density(view, light, alpha)
    target = lobe / albedo
    weight = np.sqrt((light[..., 2] > 0.0) / (drawn.shape[1] * density + even.shape[1] / (2.0 * np.pi)))

    def residual(values: Array) -> Array:
        return weight * (transformed_cosine(inverse_matrix(values), light) - target)

    best = residual(parameters)
    error = np.sum(best**2, axis=-1)
    damping = np.full(len(view), 1e-2)
    for _ in range(steps):
        nudge = 1e-5
        slope = np.stack([(residual(parameters + nudge * axis) - best) / nudge for axis in np.eye(4)], axis=-1)
        normal = np.einsum("vpi,vpj->vij", slope, slope)
        normal += damping[:, None, None] * np.einsum("vii->vi", normal)[:, :, None] * np.eye(4) + 1e-14 * np.eye(4)
        step = np.linalg.solve(normal, -np.einsum("vpi,vp->vi", slope, best)[..., None])[..., 0]
        trial = parameters + np.clip(step, -0.3, 0.3)
        trial_residual = residual(trial)
        trial_error = np.sum(trial_residual**2, axis=-1)
        better = trial_error < error
        parameters = np.where(better[:, None], trial, parameters)
        best = np.where(better[:, None], trial_residual, best)
        error = np.where(better, trial_error, error)
        damping = np.clip(np.where(better, damping / 3.0, damping * 4.0), 1e-9, 1e9)
    return parameters, np.sqrt(error / np.sum((weight * target) ** 2, axis=-1))


def fit_table(size: int) -> npt.NDArray[np.float32]:
    """The whole table, from rough to smooth: the fit of one roughness is the first guess for the next."""
    cosine = np.maximum(1.0 - np.linspace(0.0, 1.0, size) ** 2, MIN_COSINE)
    view = np.stack([np.sqrt(1.0 - cosine**2), np.zeros(size), cosine], axis=-1)
    parameters = np.stack([-0.5 * np.arccos(cosine), np.zeros(size), np.zeros(size), np.zeros(size)], axis=-1)
    table = np.empty((size, size, 6), np.float32)
    previous = 1.0
    for column in reversed(range(size)):
        alpha = (MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * column / (size - 1)) ** 2
        parameters[:, 1:3] += np.log(alpha / previous)
        previous = alpha
        albedo = albedos(view, alpha)
        parameters, error = fit(view, alpha, albedo[:, :1], parameters, steps=120 if column == size - 1 else 40)
        table[:, column, :4] = inverse_matrix(parameters)
        table[:, column, 4:] = albedo
        print(f"alpha {alpha:.4f}: relative difference mean {error.mean():.3f}, largest {error.max():.3f}", flush=True)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--out", type=Path, default=TABLE)
    options = parser.parse_args()
    np.save(options.out, fit_table(options.size))


if __name__ == "__main__":
    main()
