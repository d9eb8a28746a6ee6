"""Peer: Mitsuba 3. Traces the visibility of the rectangle from the pixels' surface points with its own ray tracer.

    python mitsuba_rays.py FOLDER      # FOLDER as run.py prepares it; README.md says what to install

Mitsuba's integrators give radiance, in which visibility is weighted by cosines and distance; this loop over its rays
gives the share that is visible, so that it can be compared without that weight. Primary rays are part of the time.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

VARIANTS = ("cuda_ad_rgb", "llvm_ad_rgb")
"""Those that trace many rays at a time; the scalar ones would take minutes from Python."""
STRATA = 17
"""On either side of the rectangle: with one ray each, 289, as many as `uniform` has shadow maps."""
OFFSET = 1e-4
"""Metres that a shadow ray starts off its surface, and share of it that it ends short of the light."""
ABOUT = (
    "ray tracing; samples area lights itself. Its integrators give radiance, so this is a loop over its rays that "
    "gives the visible share, primary rays included in the time."
)


def set_variant() -> str:
    """The fastest variant that works: both need a library that Mitsuba does not bring."""
    for variant in VARIANTS:
        try:
            mi.set_variant(variant)
            dr.eval(dr.arange(mi.Float, 2) + 1.0)  # loads it
            return variant
        except Exception as error:  # of several kinds, by variant and version
            print(f"{variant}: {error}", file=sys.stderr)
    raise SystemExit("no variant of Mitsuba works here: install LLVM 19")


def load(folder: Path) -> mi.Scene:
    """The triangles as one mesh."""
    arrays = np.load(folder / "triangles.npz")
    positions, triangles = arrays["positions"], arrays["triangles"]
    mesh = mi.Mesh("triangles", len(positions), len(triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = positions.ravel()
    parameters["faces"] = triangles.astype(np.uint32).ravel()
    parameters.update()
    return mi.load_dict({"type": "scene", "mesh": mesh})


def pixel_rays(subject: dict) -> mi.Ray3f:
    """A ray through the middle of every pixel, row 0 at the top."""
    camera, (width, height) = subject["camera"], subject["size"]
    right, up, back = np.array(camera["axes"])
    half = np.tan(np.radians(camera["vertical_fov"]) / 2.0)
    x = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * half * width / height
    y = (1.0 - (np.arange(height) + 0.5) / height * 2.0) * half
    directions = x[None, :, None] * right + y[:, None, None] * up - back
    directions = (directions / np.linalg.norm(directions, axis=2, keepdims=True)).reshape(-1, 3).T
    return mi.Ray3f(mi.Point3f(*map(float, camera["position"])), mi.Vector3f(*(mi.Float(part) for part in directions)))


def visibility(scene: mi.Scene, subject: dict, seed: int) -> np.ndarray:
    """(height, width) float32: the mean of stratified shadow rays, a row of strata of all pixels at a time."""
    width, height = subject["size"]
    light = subject["light"]
    center, (right, up, back) = mi.Point3f(*light["center"]), (mi.Vector3f(*axis) for axis in light["axes"])
    hit = scene.ray_intersect(pixel_rays(subject))
    normal = dr.select(dr.dot(hit.n, hit.to_world(hit.wi)) < 0.0, -hit.n, hit.n)
    lanes = dr.arange(mi.UInt32, STRATA * width * height)
    pixel, column = lanes // STRATA, mi.Float(lanes % STRATA)
    normal = dr.gather(mi.Vector3f, mi.Vector3f(normal), pixel)
    start = dr.gather(mi.Point3f, mi.Point3f(hit.p), pixel) + OFFSET * normal
    is_surface = dr.gather(mi.Bool, hit.is_valid(), pixel)
    random = mi.PCG32(size=STRATA * width * height, initstate=seed)
    total = dr.zeros(mi.Float, width * height)
    for row in range(STRATA):
        x = (2.0 * (column + random.next_float32()) / STRATA - 1.0) * light["half_extent"][0]
        y = (2.0 * (row + random.next_float32()) / STRATA - 1.0) * light["half_extent"][1]
        toward = center + x * right + y * up - start
        is_before = is_surface & (dr.dot(normal, toward) > 0.0) & (dr.dot(back, toward) > 0.0)
        ray = mi.Ray3f(start, toward, 1.0 - OFFSET, 0.0, [])
        seen = is_before & ~scene.ray_test(ray, active=is_before)
        total += dr.block_sum(dr.select(seen, mi.Float(1.0), mi.Float(0.0)), STRATA)
        dr.eval(total, random)
    total = dr.select(hit.is_valid(), total / STRATA**2, 1.0)
    return np.array(total, np.float32).reshape(height, width)


def main() -> None:
    folder = Path(sys.argv[1])
    subject = json.loads((folder / "subject.json").read_text())
    variant = set_variant()
    scene = load(folder)
    milliseconds = []
    image = visibility(scene, subject, 0)  # compiles
    for turn in range(subject["repeats"]):
        started = time.perf_counter()
        image = visibility(scene, subject, 1 + turn)
        milliseconds.append(1e3 * (time.perf_counter() - started))
    image.tofile(folder / "mitsuba.f32")
    row = {
        "label": f"Mitsuba, {STRATA**2} rays",
        "name": "mitsuba",
        "version": mi.__version__,
        "about": ABOUT,
        "options": {"variant": variant, "samples": STRATA**2},
        "milliseconds": milliseconds,
        "visibility": "mitsuba.f32",
    }
    (folder / "mitsuba.json").write_text(json.dumps([row]))


if __name__ == "__main__":
    main()
