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

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
SAMPLES = 289
"""Rays per pixel: as many as `uniform` has shadow maps; Mitsuba's stratified sampler takes the next square."""

ABOUT = (
    "ray tracing; samples area lights itself. Its integrators give radiance, so this is a loop over its rays that "
    "gives the visible share, primary rays included in the time."
)


def set_variant() -> str:
    """The fastest variant that works: LLVM needs a library of its own."""
    for variant in VARIANTS:
        try:
            mi.set_variant(variant)
            mi.Float(1.0) + 1.0  # type: ignore[operator]  # loads LLVM
            return variant
        except (ImportError, RuntimeError, AttributeError) as error:
            print(f"{variant}: {error}", file=sys.stderr)
    raise SystemExit("no variant of Mitsuba works here")


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
    """(height, width) float32: the mean of stratified shadow rays."""
    width, height = subject["size"]
    light = subject["light"]
    center, (right, up, back) = mi.Point3f(*light["center"]), (mi.Vector3f(*axis) for axis in light["axes"])
    hit = scene.ray_intersect(pixel_rays(subject))
    normal = dr.select(dr.dot(hit.n, hit.to_world(hit.wi)) < 0.0, -hit.n, hit.n)
    sampler = mi.load_dict({"type": "stratified", "sample_count": SAMPLES})
    sampler.seed(seed, width * height)
    total = dr.zeros(mi.Float, width * height)
    for _ in range(sampler.sample_count()):
        s = sampler.next_2d()
        x, y = (2.0 * s.x - 1.0) * light["half_extent"][0], (2.0 * s.y - 1.0) * light["half_extent"][1]
        point = center + x * right + y * up
        toward = point - hit.p
        open_to = (dr.dot(normal, toward) > 0.0) & (dr.dot(back, toward) > 0.0)
        blocked = scene.ray_test(hit.spawn_ray_to(point), active=hit.is_valid() & open_to)
        total += dr.select(open_to & ~blocked, 1.0, 0.0)
        sampler.advance()
        dr.eval(total, sampler)
    total = dr.select(hit.is_valid(), total / sampler.sample_count(), 1.0)
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
        "label": f"Mitsuba, {SAMPLES} rays",
        "name": "mitsuba",
        "version": mi.__version__,
        "about": ABOUT,
        "options": {"variant": variant, "samples": SAMPLES},
        "milliseconds": milliseconds,
        "visibility": "mitsuba.f32",
    }
    (folder / "mitsuba.json").write_text(json.dumps([row]))


if __name__ == "__main__":
    main()
