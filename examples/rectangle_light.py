"""A scene from numpy arrays under a rectangle light.

Meshes are arrays of positions and triangles; a light is placed by its centre and by what it looks at.
"""

import numpy as np

import softshadows as ss


def box(
    size: tuple[float, float, float], foot: tuple[float, float, float], color: tuple[float, float, float]
) -> ss.Node:
    """A box whose bottom face is centred at `foot`, its faces counter-clockwise seen from outside."""
    unit = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])
    corners = (unit * size + foot).astype(np.float32)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))]
    return ss.Node(ss.Mesh(corners, np.array(triangles), material=ss.Material(base_color=(*color, 1.0))))


def main(size: tuple[int, int] = (1024, 768)) -> None:
    nodes = [box((0.08, 0.7, 0.08), (x, 0.0, z), (0.3, 0.2, 0.1)) for x in (-0.7, 0.7) for z in (-0.35, 0.35)]
    nodes += [
        box((1.6, 0.06, 0.9), (0.0, 0.7, 0.0), (0.5, 0.3, 0.15)),
        box((0.2, 0.3, 0.2), (0.3, 0.76, 0.1), (0.1, 0.3, 0.5)),
    ]
    light = ss.RectLight(position=(-1.5, 3, 1), target=(0, 0.4, 0), width=1.2, height=0.6, radiance=(40, 38, 34))
    camera = ss.Camera(position=(1.6, 1.9, 3.0), target=(-0.1, 0.4, 0), vertical_fov=35)
    scene = ss.Scene(nodes, [light], camera)
    scene.add_ground()
    ss.render(scene, size=size).save("rectangle_light.png")


if __name__ == "__main__":
    main()
