"""Peer: pygfx. A spot light in the middle of the rectangle, with pygfx's shadow map and the 17 taps of its PCF.

    python pygfx_shadows.py FOLDER      # FOLDER as run.py prepares it; README.md says what to install

pygfx has no area light. It gives no visibility either: that is the ratio of the picture with and without shadows, of
matt white surfaces shaded by their geometric normals, in floats.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
import pygfx as gfx
import wgpu

BIASES = (0.0, 1e-7, 1e-6, 1e-5)
"""Depth biases that are tried; run.py reports the one with the least error, to pygfx's favour."""

DARK = 1e-3
"""Radiance below which a ratio says nothing; a surface that faces the light has up to 1/π."""

ABOUT = (
    "has no area lights: a spot light in the rectangle's middle with its shadow map of fixed size and PCF of fixed "
    "width. Visibility is the ratio of the picture with and without shadows; its lighting is part of the time."
)


def build(folder: Path, subject: dict) -> tuple[gfx.Scene, gfx.PerspectiveCamera, gfx.SpotLight]:
    """The scene under one spot light that casts shadows, and its camera."""
    arrays = np.load(folder / "triangles.npz")
    geometry = gfx.Geometry(positions=arrays["positions"], indices=arrays["triangles"].astype(np.int32))
    material = gfx.MeshPhongMaterial(color="#fff", specular="#000", flat_shading=True, side="both")
    mesh = gfx.Mesh(geometry, material)
    mesh.cast_shadow = mesh.receive_shadow = True

    given = subject["light"]
    light = gfx.SpotLight("#fff", intensity=1.0, angle=np.radians(given["cone_degrees"]), penumbra=0.0, decay=0.0)
    light.local.position = given["center"]
    light.target.local.position = np.array(given["center"]) - np.array(given["axes"][2])
    light.cast_shadow = True

    scene = gfx.Scene()
    scene.add(mesh, light, light.target)
    camera = gfx.PerspectiveCamera(subject["camera"]["vertical_fov"], depth_range=subject["camera"]["range"])
    right, up, back = np.array(subject["camera"]["axes"])
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([right, up, back, subject["camera"]["position"]])
    camera.local.matrix = matrix
    return scene, camera, light


def main() -> None:
    folder = Path(sys.argv[1])
    subject = json.loads((folder / "subject.json").read_text())
    scene, camera, light = build(folder, subject)
    width, height = subject["size"]
    camera.set_view_size(width, height)
    usage = wgpu.TextureUsage.COPY_SRC | wgpu.TextureUsage.RENDER_ATTACHMENT
    target = gfx.Texture(dim=2, size=(width, height, 1), format="rgba16float", usage=usage)
    renderer = gfx.renderers.WgpuRenderer(target, pixel_scale=1, ppaa="none")
    device = gfx.renderers.wgpu.get_shared().device

    def frame() -> np.ndarray:
        """(height, width) float32 linear radiance, read back."""
        renderer.render(scene, camera)
        source = {"texture": target._wgpu_object, "mip_level": 0, "origin": (0, 0, 0)}
        layout = {"offset": 0, "bytes_per_row": 8 * width, "rows_per_image": height}
        data = device.queue.read_texture(source, layout, (width, height, 1))
        return np.frombuffer(data, np.float16).reshape(height, width, 4)[..., 1].astype(np.float32)

    light.cast_shadow = False
    unshadowed = frame()
    light.cast_shadow = True
    rows = []
    for bias in BIASES:
        light.shadow.bias = bias
        frame()  # compiles, the first time
        milliseconds = []
        shadowed = unshadowed
        for _ in range(subject["repeats"]):
            started = time.perf_counter()
            shadowed = frame()
            milliseconds.append(1e3 * (time.perf_counter() - started))
        ratio = np.divide(shadowed, unshadowed, out=np.ones_like(shadowed), where=unshadowed > DARK)
        file = f"pygfx-{bias:g}.f32"
        np.clip(ratio, 0.0, 1.0).tofile(folder / file)
        rows.append(
            {
                "label": "pygfx, PCF",
                "name": "pygfx",
                "version": gfx.__version__,
                "about": ABOUT,
                "options": {"adapter": device.adapter.info["device"], "bias": bias},
                "milliseconds": milliseconds,
                "visibility": file,
            }
        )
    (folder / "pygfx.json").write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
