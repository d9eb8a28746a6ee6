"""What a frame costs while the light moves, and whether frames leave memory behind.

    python benchmarks/moves.py [LABEL ...]

For each technique of same_frames.py (default: all), at 64×48 on `figures` under one light: the median time of 20
frames, each with the light at another random place, and by how much the process grew over 400 more after 30. At the
end `hard` at 1024×768, drawn and read back, interleaved with drawn and left on the GPU.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import softshadows as ss

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
from moved_frames import SIZE, Stage, same_frames

MOVES, WARM, FRAMES, ROW = 20, 30, 400, 6


def main(labels: list[str]) -> None:
    configs = same_frames().CONFIGS
    for seed, config in enumerate(configs):
        if labels and config.label not in labels:
            continue
        stage = Stage(config.make(), seed)
        del stage.lights[1:]
        with ss.Renderer(stage.scene, technique=config.make(), size=SIZE) as renderer:
            moved, grown = while_the_light_moves(stage, renderer)
        print(f"{config.label:28} {moved:6.1f} ms, {grown:+6.2f} MB", flush=True)
    read, left = with_and_without_read_back()
    print(f"hard at 1024x768: read back {read:.0f} ms, left on the GPU {left:.0f} ms")


def while_the_light_moves(stage: Stage, renderer: ss.Renderer) -> tuple[float, float]:
    """Milliseconds of a frame, and megabytes that FRAMES of them leave behind."""

    def frame() -> None:
        stage.move_light()
        renderer.render(stage.camera)

    for _ in range(WARM):
        frame()
    before = resident()
    moved = statistics.median(milliseconds(frame) for _ in range(MOVES))
    for _ in range(FRAMES - MOVES):
        frame()
    return moved, resident() - before


def with_and_without_read_back() -> tuple[float, float]:
    """Milliseconds of a frame, medians of 3 interleaved rows of frames; each row ends with a frame that is read."""
    technique = ss.techniques.make_technique("hard", {})
    stage = Stage(technique, seed=0)
    del stage.lights[1:]
    with ss.Renderer(stage.scene, technique=technique, size=(1024, 768)) as renderer:

        def row(show: Callable[[ss.Camera], object]) -> float:
            started = time.perf_counter()
            for _ in range(ROW - 1):
                stage.move_light()
                show(stage.camera)
            stage.move_light()
            renderer.render(stage.camera)
            return 1e3 * (time.perf_counter() - started) / ROW

        row(renderer.render)
        times = [(row(renderer.render), row(renderer.draw)) for _ in range(3)]
    return statistics.median(first for first, _ in times), statistics.median(second for _, second in times)


def milliseconds(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - started)


def resident() -> float:
    """Megabytes of this process in memory, as Linux tells."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 2**20


if __name__ == "__main__":
    main(sys.argv[1:])
