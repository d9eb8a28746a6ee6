"""What walks do, pixel by pixel: for pictures and tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from softshadows.gpu.commands import Commands
from softshadows.gpu.timing import PassTimer
from softshadows.scene.lights import Light
from softshadows.techniques.bitmask.bitmask import BitmaskPass, WalkedLight, row_sets

WORDS = 11
"""32-bit words that look.wgsl writes for a pixel: eight of hidden samples, boxes, triangles, words."""


@dataclass(frozen=True, eq=False)
class Look:
    """What the walks of a light did: hidden (height, width, words, 32) bool, the samples that are not seen, as
    lights/rows.py orders them; boxes and triangles (height, width) that they met, and words that triangles were scanned
    along.
    """

    hidden: npt.NDArray[np.bool_]
    boxes: npt.NDArray[np.uint32]
    triangles: npt.NDArray[np.uint32]
    words: npt.NDArray[np.uint32]


def look(at_work: BitmaskPass, light: Light, index: int) -> Look:
    """The last frame's light, of which the visibility is number `index`; it has an extent."""
    walked = at_work.walked(index)
    sets = list(row_sets(light, at_work.technique.rows, at_work.refinements))
    words = [_words(at_work, walked, number) for number in range(len(sets))]
    counts = [int(rows.count) for rows in sets]
    bits = [
        np.unpackbits(np.ascontiguousarray(each[..., :8]).view(np.uint8), axis=-1, bitorder="little")
        .reshape(*each.shape[:2], 8, 32)[:, :, :count]
        .astype(bool)
        for each, count in zip(words, counts, strict=True)
    ]
    boxes, triangles, marked = np.moveaxis(np.sum([each[..., 8:] for each in words], axis=0, dtype=np.uint32), -1, 0)
    return Look(np.concatenate(bits, axis=2), boxes, triangles, marked)


def _words(at_work: BitmaskPass, walked: WalkedLight, number: int) -> npt.NDArray[np.uint32]:
    gpu, (width, height) = at_work.context.gpu, at_work.context.gbuffer.size
    looks = gpu.storage_buffer(4 * WORDS * width * height, "what walks do")
    program = walked.program("look.wgsl", "cs_look", number, {"looks": looks})
    commands = Commands(gpu, PassTimer(gpu))
    walked.tree.encode(commands)
    with commands.compute("look") as compute:
        program.dispatch(compute, (-(-width // 8), -(-height // 8)))
    commands.submit()
    return np.asarray(gpu.device.queue.read_buffer(looks)).view(np.uint32).reshape(height, width, WORDS)
