"""A picture described in a file, with two lights.

A shot is a TOML file that names scene, size, camera, lights and technique; `desk.toml` lies beside this script.
"""

from pathlib import Path

import softshadows as ss


def main(size: tuple[int, int] | None = None) -> None:
    shot = ss.load_shot(Path(__file__).with_name("desk.toml"))
    assert shot.technique is not None
    technique = ss.techniques.make_technique(shot.technique.name, shot.technique.options)
    frame = ss.render(shot.scene, shot.camera, technique=technique, size=size or shot.size)
    frame.save("shot.png")
    frame.save("shot.exr")  # linear radiance, and the visibility of each light as a layer of its own
    print(f"{len(frame.lights)} lights, {frame.stats.shadow_maps} shadow maps")


if __name__ == "__main__":
    main()
