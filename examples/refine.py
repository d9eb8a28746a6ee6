"""A still picture that steps toward the truth.

`refine` averages frames over ever other points of the light. The picture shows visibility after one frame and after
all of them: few samples band, many do not.
"""

import numpy as np
from PIL import Image

import softshadows as ss


def main(size: tuple[int, int] = (512, 384), frames: int = 16) -> None:
    scene = ss.scenes.blocker(height=7.0, light_half=(2.5, 2.5))
    assert scene.camera is not None
    kept = []
    with ss.Renderer(scene, technique=ss.techniques.Uniform(grid=4), size=size) as renderer:
        for count in range(1, frames + 1):
            frame = renderer.refine(scene.camera)
            kept.append(frame.visibility[0])
            if count & (count - 1) == 0:  # 1, 2, 4, 8 ...
                truth = ss.truth.visibility(scene, frame, samples=256)[0]
                error = ss.metrics.compare(frame.visibility[0], truth, frame.surface & frame.facing[0])
                print(f"{count:3} frames   rmse {error.rmse:.4f}")
    Image.fromarray(np.rint(255 * np.hstack([kept[0], kept[-1]])).astype(np.uint8)).save("refine.png")


if __name__ == "__main__":
    main()
