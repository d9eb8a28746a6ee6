"""A tube as a line light.

Techniques for line lights need a few shadow maps where averaging point lights needs dozens.
"""

import softshadows as ss


def main(size: tuple[int, int] = (1024, 768)) -> None:
    scene = ss.scenes.figures()
    scene.lights = [ss.LineLight(start=(-1.6, 2.6, 1.0), end=(1.6, 2.9, -0.6), radiance=(20, 21, 24))]
    frame = ss.render(scene, technique="occluding_edges", size=size)
    frame.save("line_light.png")
    print(f"{frame.stats.shadow_maps} shadow maps, {frame.stats.lookups_per_pixel:.0f} look-ups per pixel")


if __name__ == "__main__":
    main()
