"""Shadow mattes as float arrays, from a batch of cameras, without a window.

A renderer keeps scene and shaders on the GPU between frames. Each file holds the visible share of the light (1 lit, 0
umbra), the surface mask, depth and positions as 32-bit floats; the picture shows all mattes.
"""

import math

import numpy as np
from PIL import Image

import softshadows as ss


def main(size: tuple[int, int] = (1024, 768), count: int = 6) -> None:
    scene = ss.scenes.mannequin()
    angles = [2 * math.pi * k / count for k in range(count)]
    cameras = [ss.Camera((4 * math.cos(a), 2.1, 4 * math.sin(a)), (0.3, 0.6, -0.3), 40) for a in angles]
    mattes = []
    with ss.Renderer(scene, size=size) as renderer:
        for k, camera in enumerate(cameras):
            frame = renderer.render(camera)
            frame.save(f"matte{k}.npz")
            mattes.append(frame.visibility[0])
    sheet = np.vstack([np.hstack(mattes[::2]), np.hstack(mattes[1::2])])
    Image.fromarray(np.rint(255 * sheet).astype(np.uint8)).save("shadow_mattes.png")


if __name__ == "__main__":
    main()
