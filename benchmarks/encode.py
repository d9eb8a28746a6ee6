"""CPU milliseconds to prepare and encode a frame of `uniform` with 289 maps of 512² on the atrium, once warm.

    python benchmarks/encode.py [--uncut]

A software rasteriser needs the frame cut into submits, each with passes of its own; --uncut encodes it as a GPU would
get it.
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics

import softshadows as ss
from softshadows import renderer as renderer_module
from softshadows.gpu import device
from softshadows.gpu.budget import HARDWARE, Budget


class FastGpu(device.Gpu):
    """The same device, taken for fast enough that nothing has to be cut."""

    @property
    def budget(self) -> Budget:
        return dataclasses.replace(HARDWARE, triangles_per_ms=10**9, lookups_per_ms=10**12)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--uncut", action="store_true")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--frames", type=int, default=5)
    arguments = parser.parse_args()
    if arguments.uncut:
        gpu = device.acquire()
        fast = FastGpu(gpu.adapter, gpu.device, gpu.features, gpu.fallbacks)
        renderer_module.acquire = lambda profile: fast
    width, height = map(int, arguments.size.split("x"))
    scene = ss.scenes.atrium()
    assert scene.camera is not None
    with ss.Renderer(scene, technique=ss.techniques.Uniform(resolution=512), size=(width, height)) as renderer:
        frames = [renderer.render(scene.camera).stats for _ in range(arguments.frames + 1)][1:]
    times = [stats.cpu_ms for stats in frames]
    print(f"{scene.triangle_count} triangles, {frames[0].shadow_maps} maps, {frames[0].submits} submits")
    print(f"encode: median {statistics.median(times):.2f} ms (from {min(times):.2f} to {max(times):.2f})")


if __name__ == "__main__":
    main()
