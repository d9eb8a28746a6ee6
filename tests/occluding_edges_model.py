"""Occluding Edges Soft Shadows once more, in flatland and float64: one row of the maps, to check the shaders' maths.

A row is a plane through the light. In it a point has a position x along the light and a distance d from the light's
axis; a light sample at s sees it in the direction u = (x - s) / d, and its inverse depth is w = 1 / d. So its direction
from a sample `length` farther along is u - length w: what the paper calls the corresponding pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Circle:
    """A round occluder: its centre's x, distance from the light's axis, radius."""

    x: float
    distance: float
    radius: float

    def seen_from(self, sample: float, u: Array) -> Array:
        """Distance from the axis of the first hit in each direction, inf where there is none."""
        x, r2 = self.x - sample, self.radius**2
        a, b, c = 1.0 + u * u, x * u + self.distance, x * x + self.distance**2 - r2
        root = b * b - a * c
        return np.where(root >= 0.0, (b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf)

    def hides(self, start: Array, end: Array) -> npt.NDArray[np.bool_]:
        """Does it meet the segments from `start` to `end`, each (..., 2) of x and distance?"""
        center = np.array([self.x, self.distance])
        along = end - start
        share = np.clip(((center - start) * along).sum(-1) / (along * along).sum(-1), 0.0, 1.0)
        return ((start + share[..., None] * along - center) ** 2).sum(-1) < self.radius**2


@dataclass(frozen=True)
class Card:
    """A flat occluder parallel to the light, from x `low` to `high`."""

    low: float
    high: float
    distance: float

    def seen_from(self, sample: float, u: Array) -> Array:
        x = sample + u * self.distance
        return np.where((x > self.low) & (x < self.high), self.distance, np.inf)

    def hides(self, start: Array, end: Array) -> npt.NDArray[np.bool_]:
        share = (self.distance - start[..., 1]) / (end - start)[..., 1]
        x = start[..., 0] + share * (end - start)[..., 0]
        return (x > self.low) & (x < self.high)


@dataclass(frozen=True)
class Flatland:
    """Occluders over a floor at distance `floor` + `slope` x, under a light from -a to a."""

    occluders: tuple[Circle | Card, ...]
    a: float
    floor: float
    slope: float = 0.0

    def receivers(self, x: Array) -> Array:
        """(n, 2): the floor's points at `x`."""
        return np.stack([x, self.floor + self.slope * x], axis=-1)

    def inverse_depth(self, sample: float, u: Array) -> Array:
        """A row of the sample's map."""
        distance = (self.floor + self.slope * sample) / (1.0 - self.slope * u)
        for occluder in self.occluders:
            distance = np.minimum(distance, occluder.seen_from(sample, u))
        return 1.0 / distance

    def visibility(self, x: Array, samples: int = 4000) -> Array:
        """The share of the light that the floor's points see, by brute force."""
        points = self.receivers(x)
        light = self.a * ((2.0 * np.arange(samples) + 1.0) / samples - 1.0)
        hidden = np.zeros((len(x), samples), bool)
        for occluder in self.occluders:
            ends = np.stack([light, np.zeros(samples)], axis=-1)
            hidden |= occluder.hides(points[:, None, :], np.broadcast_to(ends, (len(x), samples, 2)))
        return 1.0 - hidden.mean(axis=1)


def angles_share(left: Array, right: Array, fragment: Array, edge: Array) -> Array:
    """[Reimann2016 §3.4 substep 4.3] i = sin β sin δ / (sin α sin(π - δ - γ)), from points (..., 2)."""

    def angle(at: Array, one: Array, other: Array) -> Array:
        a, b = one - at, other - at
        return np.arctan2(np.abs(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]), (a * b).sum(-1))

    alpha, beta = angle(fragment, left, right), angle(right, left, fragment)
    gamma, delta = angle(left, right, fragment), angle(fragment, left, edge)
    return np.sin(beta) * np.sin(delta) / (np.sin(alpha) * np.sin(np.pi - delta - gamma))


def edge_share(u: Array, w: Array, edge_u: Array, edge_w: Array, length: Array | float) -> Array:
    """The same number from directions and inverse depthes in the left sample's map."""
    return (edge_u - u) / ((edge_w - w) * length)


def influences(low: Array, high: Array) -> tuple[Array, Array]:
    """[Reimann2016 §3.4 substep 4.3] A of the right sample, B of the left one, for a lit part [low, high], f linear."""
    toward_right = (high**2 - low**2) / 2.0
    return toward_right, (high - low) - toward_right


def occluding_edges(
    u: Array, w: Array, length: float, *, map_samples: int = 1, half_texel: float = 0.0
) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """[Reimann2016 §3.2, §3.3] Of each texel in a left map's row: its edge's u and w, and whether it has one.

    Walking left, texels keep their order in the other map. Those behind the first one that does not are in its
    penumbra, until the order is back. `length` of the light is negative for a right map, whose row is walked to the
    right. With several `map samples`, the order in as many maps along the light counts, and the edge that hides most.
    """
    if length < 0.0:
        edge_u, edge_w, found = occluding_edges(
            -u[::-1], w[::-1], -length, map_samples=map_samples, half_texel=half_texel
        )
        return -edge_u[::-1], edge_w[::-1], found[::-1]
    edge_u, edge_w = np.zeros((2, len(u)))
    best_share = np.ones(len(u))
    for map_sample in range(1, map_samples + 1):
        other = u - length * map_sample / map_samples * w
        best, lowest = -1, np.inf
        for texel in range(len(u) - 1, -1, -1):
            if other[texel] > lowest:
                jumps = abs(other[best - 1] - other[best]) > 2.0 * half_texel
                own_u = u[best] - half_texel * jumps
                share = edge_share(u[texel], w[texel], own_u, w[best], length)
                if share < best_share[texel]:
                    edge_u[texel], edge_w[texel], best_share[texel] = own_u, w[best], share
            if other[texel] < lowest:
                best, lowest = texel, other[texel]
    return edge_u, edge_w, best_share < 1.0


def is_seen(world: Flatland, sample: float, x: Array) -> npt.NDArray[np.bool_]:
    """Do the floor's points at `x` see the sample?"""
    points = world.receivers(x)
    light = np.broadcast_to(np.array([sample, 0.0]), points.shape)
    return ~np.any([occluder.hides(points, light) for occluder in world.occluders], axis=0)


def segment_visibility(
    world: Flatland, x: Array, low: float, high: float, texels: int, reach: float, *, repaired: bool
) -> Array:
    """[Reimann2016 §3.4] The share of the light from `low` to `high` that the floor's points at `x` see.

    With a map at each end, of `texels` over |u| < `reach`. Not `repaired`: the paper's.
    """
    u = reach * ((2.0 * np.arange(texels) + 1.0) / texels - 1.0)
    points = world.receivers(x)
    shares, seen = [], []
    for sample, length in ((low, high - low), (high, low - high)):
        w = world.inverse_depth(sample, u)
        map_samples = 4 if repaired else 1
        edge_u, edge_w, found = occluding_edges(u, w, length, map_samples=map_samples, half_texel=reach / texels)
        own_u, own_w = (points[:, 0] - sample) / points[:, 1], 1.0 / points[:, 1]
        texel = np.clip(((own_u / reach + 1.0) * texels / 2.0).astype(int), 0, texels - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(edge_share(own_u, own_w, edge_u[texel], edge_w[texel], length), 0.0, 1.0)
        shares.append(np.where(found[texel], share, 1.0))
        seen.append(is_seen(world, sample, x))
    (left, right), (sees_low, sees_high) = shares, seen
    neither = np.zeros(len(x)) if repaired else np.where((left < 1) | (right < 1), np.maximum(left + right - 1, 0), 0)
    both = np.minimum(left + right, 1.0) if repaired else np.ones(len(x))
    return np.select([sees_low & sees_high, sees_low, sees_high], [both, left, right], neither)


def line_visibility(
    world: Flatland, x: Array, texels: int, reach: float, *, samples: int = 2, repaired: bool = False
) -> Array:
    """The mean of the segments between `samples` points of the light."""
    ends = np.linspace(-world.a, world.a, samples)
    parts = [segment_visibility(world, x, low, high, texels, reach, repaired=repaired) for low, high in pairwise(ends)]
    return np.mean(parts, axis=0)
