"""How far a long run has come, told in shares of its time rather than of its steps.

A step takes as long as the last step of its kind took; before there was one, as long as the mean of those that are
done. So a second picture of the same techniques is foreseen well, a first one roughly.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from statistics import fmean

from softshadows.compare.measure import Notice


class Schedule:
    """Steps that are expected, each of a kind; tells `notice` which is done now and the share of time that is over."""

    def __init__(self, notice: Notice) -> None:
        self._notice = notice
        self._ahead: list[str] = []
        self._seconds: dict[str, float] = {}
        self._over = 0.0
        self._share = 0.0

    def expect(self, kind: str) -> None:
        """One more step of this kind is to come."""
        self._ahead.append(kind)

    def tell(self, doing: str) -> None:
        """Say what is done, between steps."""
        self._notice(doing, self._share)

    @contextmanager
    def step(self, kind: str, doing: str) -> Iterator[Notice]:
        """Do a step that was expected. What it tells of itself, a part and its share, goes on to `notice`."""
        self._ahead.remove(kind)
        started = time.perf_counter()

        def within(part: str, share: float) -> None:
            spent = time.perf_counter() - started
            whole = spent / share if share > 0.0 else max(self._foreseen(kind, spent), spent)
            over = self._over + spent
            total = self._over + whole + sum(self._foreseen(ahead, whole) for ahead in self._ahead)
            self._share = over / total if total > 0.0 else 0.0
            self.tell(f"{doing}, {part}" if part else doing)

        within("", 0.0)
        yield within
        self._seconds[kind] = time.perf_counter() - started
        self._over += self._seconds[kind]

    def _foreseen(self, kind: str, unknown: float) -> float:
        """Seconds that a step of this kind will take; `unknown` where no step is done."""
        return self._seconds.get(kind, fmean(self._seconds.values()) if self._seconds else unknown)
