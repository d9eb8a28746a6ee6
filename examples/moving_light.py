"""An animation: the light goes round the scene.

Lights, node transforms and the camera may change between frames of one renderer; only what changed is done again.
"""

import math

from PIL import Image

import softshadows as ss


def main(size: tuple[int, int] = (640, 480), count: int = 24) -> None:
    scene = ss.scenes.sphere_cube()
    assert scene.camera is not None
    pictures = []
    with ss.Renderer(scene, technique=ss.techniques.Pcss(), size=size) as renderer:
        for k in range(count):
            angle = 2 * math.pi * k / count
            place = (3 * math.cos(angle), 6, 3 * math.sin(angle))
            scene.lights = [ss.RectLight(place, target=(0, 1, 0), width=1, height=1, radiance=(60, 60, 60))]
            renderer.render(scene.camera).save("frame.png")
            pictures.append(Image.open("frame.png").quantize(64))
    pictures[0].save("moving_light.gif", save_all=True, append_images=pictures[1:], duration=80, loop=0)


if __name__ == "__main__":
    main()
