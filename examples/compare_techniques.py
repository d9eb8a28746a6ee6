"""Several techniques beside ray-traced truth: figures, and where each one errs.

Error maps, in rows as listed: orange is too light, blue too dark. `softshadows compare` makes a whole page.
"""

import numpy as np
from PIL import Image

import softshadows as ss

NAMES = ("hard", "pcss", "variable_penumbra", "adaptive")


def main(size: tuple[int, int] = (512, 384), samples: int = 256) -> None:
    scene = ss.scenes.sphere_cube()
    maps = []
    for name in NAMES:
        frame = ss.render(scene, technique=name, size=size)
        truth = ss.truth.visibility(scene, frame, samples=samples)[0]
        mask = frame.surface & frame.facing[0]
        error = ss.metrics.compare(frame.visibility[0], truth, mask)
        print(f"{name:20} rmse {error.rmse:.4f}   leak rate {error.leak_rate:.2%}   bias {error.bias:+.4f}")
        maps.append(ss.metrics.signed_error_image(frame.visibility[0], truth, mask))
    sheet = np.vstack([np.hstack(maps[:2]), np.hstack(maps[2:])])
    Image.fromarray(np.rint(255 * sheet).astype(np.uint8)).save("compare_techniques.png")


if __name__ == "__main__":
    main()
