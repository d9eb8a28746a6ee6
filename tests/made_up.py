"""A measurement without a GPU: two techniques over a ramp from umbra to light, one exact and one too light by 0.05."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softshadows import metrics
from softshadows.compare.interleaved import Timing, label_of
from softshadows.compare.measure import Measurement, Reference, Result
from softshadows.scene.shot import open_shot
from softshadows.techniques import make_technique

HEIGHT, WIDTH = 24, 32
OFFSET = 0.05
ENVIRONMENT = {
    "adapter": {"adapter": "a <b>", "backend": "Vulkan", "driver": "d", "features": [], "fallbacks": [], "limits": {}},
    "cpu": "c",
    "cpu_count": 2,
    "system": "s",
    "versions": {"python": "3", "embreex": None},
    "commit": None,
}


def measurement(lights: int = 1, name: str = "<script>alert(1)</script>") -> Measurement:
    """Labels `uniform:grid=3`, exact and slow, and `uniform:grid=5`, too light and fast."""
    truth = np.tile(np.clip(np.linspace(-1.0, 2.0, WIDTH, dtype=np.float32), 0, 1), (lights, HEIGHT, 1))
    mask = np.ones_like(truth, bool)
    picture = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    shot = replace(open_shot("blocker"), size=(WIDTH, HEIGHT), name=name)
    shot.scene.lights = shot.scene.lights * lights
    stats = {"shadow_maps": 9, "lookups_per_pixel": 9.0, "gpu_ms": {"lookup": 1.0}, "cpu_ms": 1.0, "gpu_bytes": 10}
    made = []
    for grid, offset, frame_ms in ((3, 0.0, 2.0), (5, OFFSET, 1.5)):
        technique = make_technique("uniform", {"grid": grid})
        visibility = truth + np.float32(offset)
        comparisons = [metrics.compare(*light) for light in zip(visibility, truth, mask, strict=True)]
        timing = {"frame": Timing.of([frame_ms]), "cached": Timing.of([1.0])}
        made.append(
            Result(technique, label_of(technique), visibility, picture, comparisons, None, timing, stats, ["a & b"])
        )
    reference = Reference(truth, mask, picture, 0.0, samples=64, standard_error=0.01, seconds=0.5)
    return Measurement(shot, reference, made, ["vsm: cannot <do> it"])
