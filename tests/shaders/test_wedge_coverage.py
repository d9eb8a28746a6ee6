"""The wedges' WGSL against float64 polygon clipping: areas, quarters, rectangles, and the statistics of blending."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import wgpu

import softshadows
from softshadows.gpu.compose import compose
from softshadows.gpu.device import acquire

FOLDER = Path(softshadows.__file__).parent / "techniques" / "penumbra_wedges"
Array = npt.NDArray[np.float64]
Outline = npt.NDArray[np.float64]
"""(n, 2) corners in light units: the light is [-1, 1]²."""

KERNEL = """
@group(0) @binding(0) var<storage, read_write> results: array<vec4f>;
@group(0) @binding(1) var<storage, read> starts: array<u32>;   // of each outline's corners, and the end
@group(0) @binding(2) var<storage, read> corners: array<vec4f>;  // homogeneous; the winding about the centre
@group(0) @binding(3) var<storage, read> groups: array<u32>;   // of outlines that are blended, and the end
const LENGTH = 12u;

fn add_outline(index: u32) {
    let first = starts[index];
    let count = starts[index + 1u] - first;
    begin_silhouette(corners[first].w);
    for (var i = 0u; i < count; i++) {
        let q0 = corners[first + i].xyz;
        let q1 = corners[first + (i + 1u) % count].xyz;
        add_edge(q0, q1, q0.x * q1.y - q1.x * q0.y > 0.0, 1.0);
    }
}

@compute @workgroup_size(1) fn cs_test(@builtin(workgroup_id) id: vec3u) {
    let group = id.y * 1024u + id.x;
    if group + 1u >= arrayLength(&groups) {
        return;
    }
    var sum = 0.0;
    var lit = 1.0;
    for (var i = groups[group]; i < groups[group + 1u]; i++) {
        add_outline(i);
        sum += silhouette_share();
        lit *= 1.0 - saturate(silhouette_share());
        if i + 1u == groups[group + 1u] {
            for (var k = 0u; k < 4u; k++) {
                let sums = vec3i(silhouette[k].area_sum, silhouette[k].moment_sum);
                results[LENGTH * group + k] = vec4f(vec3f(sums) / WHOLE, 0.0);
            }
        }
        blend_silhouette();
        if i + 1u == groups[group + 1u] {
            for (var k = 0u; k < 4u; k++) {
                results[LENGTH * group + 4u + k] = vec4f(silhouette[k].low, silhouette[k].high);
            }
        }
    }
    results[LENGTH * group + 8u] = vec4f(sum, 1.0 - lit, combined_share(), 0.0);
}
"""


@cache
def module() -> wgpu.GPUShaderModule:
    source = compose(FOLDER / "parts.wgsl").text
    return acquire().device.create_shader_module(code=source + KERNEL)


def run(groups: list[list[Outline]], **constants: bool) -> npt.NDArray[np.float32]:
    """(groups, 12, 4): by quarter share and moments, by quarter rectangle (both of the last outline), combinations."""
    device = acquire().device
    outlines = [outline for group in groups for outline in group]
    starts = np.cumsum([0, *(len(outline) for outline in outlines)]).astype(np.uint32)
    ends = np.cumsum([0, *(len(group) for group in groups)]).astype(np.uint32)
    corners = np.ones((starts[-1], 4), np.float32)
    corners[:, :2] = np.concatenate(outlines)
    corners[starts[:-1], 3] = [winding(outline, np.zeros(2)) for outline in outlines]
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    result = device.create_buffer(size=12 * 16 * len(groups), usage=usage)
    inputs = [device.create_buffer_with_data(data=data, usage=usage) for data in (starts, corners, ends)]
    compute = {"module": module(), "entry_point": "cs_test", "constants": {k: float(v) for k, v in constants.items()}}
    pipeline = device.create_compute_pipeline(layout="auto", compute=compute)
    entries = [{"binding": i, "resource": {"buffer": buffer}} for i, buffer in enumerate([result, *inputs])]
    bindings = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    work = encoder.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, bindings)
    work.dispatch_workgroups(1024, -(-len(groups) // 1024))
    work.end()
    device.queue.submit([encoder.finish()])
    data = device.queue.read_buffer(result)
    return np.frombuffer(data, np.float32).reshape(len(groups), 12, 4)  # type: ignore[arg-type]


# -- float64 -----------------------------------------------------------------------------------------------------------


def winding(outline: Outline, point: Array) -> int:
    """How often the outline runs around the point, counter-clockwise."""
    a = outline - point
    b = np.roll(a, -1, axis=0)
    turns = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    return round(turns.sum() / (2.0 * np.pi))


def clipped(outline: Outline, low: Array, high: Array) -> Outline:
    """The outline within a box (Sutherland and Hodgman 1974); degenerate edges along the box have no area."""
    for axis in (0, 1):
        for sign, limit in ((1.0, low[axis]), (-1.0, -high[axis])):
            points = []
            for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
                da, db = sign * a[axis] - limit, sign * b[axis] - limit
                if da >= 0.0:
                    points.append(a)
                if (da >= 0.0) != (db >= 0.0):
                    points.append(a + (b - a) * da / (da - db))
            outline = np.array(points).reshape(-1, 2)
            if not len(outline):
                return outline
    return outline


def area(outline: Outline) -> float:
    x, y = outline.T
    return float(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) if len(outline) else 0.0


def center_of(outline: Outline) -> Array:
    x, y = outline.T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    return np.array([((v + np.roll(v, -1)) * cross).sum() for v in (x, y)]) / 6.0


QUARTERS = [(np.array([x0, y0]), np.array([x0, y0]) + 1.0) for x0, y0 in ((0, 0), (-1, 0), (-1, -1), (0, -1))]
MIRRORS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], np.float64)


def convex(random: np.random.Generator) -> Outline:
    """Corners on an ellipse."""
    angles = np.sort(random.uniform(0.0, 2.0 * np.pi, random.integers(3, 12)))
    return _placed(random, np.stack([np.cos(angles), np.sin(angles)], axis=1))


def star(random: np.random.Generator) -> Outline:
    """Corners in the order of their angle, at any distance: simple, not convex."""
    angles = np.sort(random.uniform(0.0, 2.0 * np.pi, random.integers(3, 12)))
    radius = random.uniform(0.1, 1.0, len(angles))[:, None]
    if np.diff(angles, append=angles[0] + 2.0 * np.pi).max() > 3.0:
        return star(random)  # not around its own centre
    return _placed(random, radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _placed(random: np.random.Generator, points: Outline) -> Outline:
    turn = random.uniform(0.0, 2.0 * np.pi)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    placed = points * random.uniform(0.1, 4.0, 2) @ rotation.T + random.uniform(-1.5, 1.5, 2)
    return placed.astype(np.float32).astype(np.float64)  # what the shader sees


@pytest.mark.parametrize("make", [convex, star])
def test_areas_of_ten_thousand_outlines(make: object) -> None:
    """Fidelity checks 1, 3 and 4: quarters to 1e-5, none further out of [0, 1], and they make up the whole."""
    random = np.random.default_rng(5)
    outlines = [make(random) for _ in range(5000)]  # type: ignore[operator]
    results = run([[outline] for outline in outlines], uses_gravity=True)
    pieces = [[clipped(outline, low, high) for low, high in QUARTERS] for outline in outlines]
    expected = np.array([[area(piece) for piece in row] for row in pieces])
    shares = results[:, :4, 0]
    assert np.abs(shares - expected).max() <= 1e-5
    assert shares.min() >= -1e-5
    assert shares.max() <= 1.0 + 1e-5
    assert np.abs(4.0 * results[:, 8, 0] - expected.sum(axis=1)).max() <= 1e-5
    moments = np.array([[center_of(piece) if len(piece) else np.zeros(2) for piece in row] for row in pieces])
    assert np.abs(results[:, :4, 1:3] - moments * MIRRORS).max() <= 1e-5
    assert (expected > 0.01).any(axis=1).mean() > 0.5, "most outlines meet the light"


def test_rectangles_are_exact_or_the_papers() -> None:
    """`exact` bounds what is occluded of a quarter, always; the paper's rule loses a part of it for some outlines."""
    random = np.random.default_rng(6)
    outlines = [convex(random) for _ in range(2000)]
    exact = run([[outline] for outline in outlines], exact_rectangles=True)[:, 4:8]
    paper = run([[outline] for outline in outlines], exact_rectangles=False)[:, 4:8]
    lost = cases = 0
    for index, outline in enumerate(outlines):
        for k, (low, high) in enumerate(QUARTERS):
            piece = clipped(outline, low, high) * MIRRORS[k]
            if abs(area(piece)) < 1e-3:
                continue
            box = np.concatenate([piece.min(axis=0), piece.max(axis=0)])
            assert np.abs(exact[index, k] - box).max() <= 1e-5
            cases += 1
            lost += bool((paper[index, k, :2] > box[:2] + 1e-3).any() or (paper[index, k, 2:] < box[2:] - 1e-3).any())
    assert cases > 1000
    assert 0.01 <= lost / cases <= 0.15  # papers.md section 5.4: 5.5 % of its cases


# -- Blending ----------------------------------------------------------------------------------------------------------


def rectangle(x0: float, x1: float, y0: float, y1: float) -> Outline:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], np.float64)


@pytest.mark.parametrize(
    ("first", "second", "union"),
    [
        (rectangle(-1, -0.5, -1, 1), rectangle(0.25, 0.5, -1, 1), 0.375),  # apart
        (rectangle(0, 0.5, 0, 0.5), rectangle(0.25, 0.5, 0, 1), 0.09375),  # fill their rectangles, overlap
        (rectangle(-1, 0, -1, 1), rectangle(-0.5, 0.5, -1, 1), 0.75),
        (rectangle(-2, 2, -2, 2), rectangle(-0.5, 0.5, -0.5, 0.5), 1.0),  # one inside the other
    ],
)
def test_rectangles_on_the_axes_unite_exactly(first: Outline, second: Outline, union: float) -> None:
    """Fidelity check 5."""
    assert run([[first, second]])[0, 8, 2] == pytest.approx(union, abs=1e-6)


def test_triangles_in_one_rectangle_are_the_known_deviation() -> None:
    """Fidelity check 6: a quarter of overlap is taken away, of two equal triangles and of two that share nothing."""
    lower, upper = np.array([(0.0, 0), (1, 0), (1, 1)]), np.array([(0.0, 0), (1, 1), (0, 1)])
    results = run([[lower, lower], [lower, upper]])[:, 8, 2]
    assert results == pytest.approx([0.75 / 4.0, 0.75 / 4.0], abs=1e-6)
    # The centre of gravity tells the two apart, in the right direction.
    same, complementary = run([[lower, lower], [lower, upper]], uses_gravity=True)[:, 8, 2]
    assert 0.5 / 4.0 <= same < 0.7 / 4.0
    assert 0.8 / 4.0 < complementary <= 1.0 / 4.0


RASTER = (np.arange(128) + 0.5) / 64.0 - 1.0
TRIALS = 400
PAPER = {2: (0.058, 0.040, 0.007), 3: (0.108, 0.053, 0.013), 5: (0.209, 0.076, 0.022)}
"""Discs to RMS of plain sum, independent product and four parts: papers.md, section 5.7."""


def discs(count: int) -> tuple[list[list[Outline]], Array]:
    """TRIALS sets of discs as 16-gons, and the share of the light that each set covers, on a raster of 128²."""
    random = np.random.default_rng(count)
    angles = np.arange(16) * 2.0 * np.pi / 16.0
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sets, shares = [], []
    x, y = np.meshgrid(RASTER, RASTER)
    normals = np.stack([np.cos(angles + np.pi / 16), np.sin(angles + np.pi / 16)])
    for _ in range(TRIALS):
        centers, radii = random.uniform(-1.2, 1.2, (count, 2)), random.uniform(0.2, 0.9, count)
        covered = np.zeros(x.shape, bool)
        for (cx, cy), radius in zip(centers, radii, strict=True):
            apothem = radius * np.cos(np.pi / 16)
            offsets = np.stack([(x - cx).ravel(), (y - cy).ravel()])
            covered |= (np.max(normals.T @ offsets, axis=0) <= apothem).reshape(x.shape)
        sets.append([center + radius * circle for center, radius in zip(centers, radii, strict=True)])
        shares.append(covered.mean())
    return sets, np.array(shares)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_blending_random_discs_errs_as_it_should(count: int) -> None:
    """R13: within 25 % of the statistics, in order, and the plain sum always too dark."""
    sets, truth = discs(count)
    error = run(sets)[:, 8, :3] - truth[:, None]
    clamped = run(sets)[:, 8, :3].clip(0.0, 1.0) - truth[:, None]
    plain, product, parts = np.sqrt((error**2).mean(axis=0))
    clamped_plain = np.sqrt((clamped[:, 0] ** 2).mean())
    expected = PAPER[count]
    assert min(plain, clamped_plain) <= 1.25 * expected[0]
    assert max(plain, clamped_plain) >= 0.75 * expected[0]
    assert product == pytest.approx(expected[1], rel=0.25)
    assert parts == pytest.approx(expected[2], rel=0.25)
    assert parts < product / 3.0
    assert error[:, 0].min() > -0.002  # the raster's own error
    gravity = np.sqrt(((run(sets, uses_gravity=True)[:, 8, 2] - truth) ** 2).mean())
    eight_bits = np.sqrt(((run(sets, eight_bits=True)[:, 8, 2] - truth) ** 2).mean())
    print(
        f"{count} discs: plain {plain:.4f} ({clamped_plain:.4f}) product {product:.4f} parts {parts:.4f} "
        f"gravity {gravity:.4f} 8 bits {eight_bits:.4f}"
    )
    assert gravity < parts
    assert eight_bits == pytest.approx(parts, rel=0.15)
