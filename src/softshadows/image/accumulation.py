"""The mean of frames that show the same, each with other samples of its lights: it steps toward the truth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]


class Refinement:
    """The frames so far, summed up; `subject` is what they all show, and tells it from other pictures."""

    def __init__(self, subject: object) -> None:
        self.subject = subject
        self.frames = 0
        self._color = self._visibility = np.zeros(1)

    def add(self, color: Floats, visibility: Floats) -> tuple[Floats, Floats]:
        """Take in a frame's images, and return the means of all."""
        self.frames += 1
        self._color, self._visibility = self._color + color, self._visibility + visibility
        return (self._color / self.frames).astype(np.float32), (self._visibility / self.frames).astype(np.float32)
