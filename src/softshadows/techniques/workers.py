"""Who finds the visibility of which light: each has a worker where memory allows it, others share one, one by one.

A worker that has one light alone can cache its shadow maps from frame to frame.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from typing import Generic, Protocol, TypeVar


class Worker(Protocol):
    """What holds buffers for one light at a time."""

    @property
    def bytes(self) -> int:
        """On the GPU."""
        ...

    @property
    def can_cache(self) -> bool:
        """Can it keep anything from frame to frame, if it has one light alone?"""
        ...


KeyT = TypeVar("KeyT", bound=Hashable)
WorkerT = TypeVar("WorkerT", bound=Worker)


class Workers(Generic[KeyT, WorkerT]):
    """Workers by the kind of light that they are made for. Those of a kind that cache fit `memory_budget` MiB."""

    def __init__(self, make: Callable[[KeyT], WorkerT], memory_budget: int) -> None:
        self._make, self._budget = make, memory_budget * 2**20
        self._by_kind: dict[KeyT, list[WorkerT]] = {}

    def assign(self, kinds: Mapping[int, KeyT]) -> dict[int, tuple[WorkerT, int]]:
        """By light: its worker, and its place among those of that worker; from the lights' kinds."""
        numbers = Counter(kinds.values())
        workers = {kind: self._workers(kind, number) for kind, number in numbers.items()}
        counted: Counter[KeyT] = Counter()
        by_light = {}
        for light, kind in kinds.items():
            own, number = workers[kind], counted[kind]
            by_light[light] = own[number % len(own)], number // len(own)
            counted[kind] += 1
        return by_light

    def _workers(self, kind: KeyT, lights: int) -> list[WorkerT]:
        workers = self._by_kind.setdefault(kind, [])
        if not workers:
            workers.append(self._make(kind))
        wanted = lights if workers[0].can_cache and lights * workers[0].bytes <= self._budget else 1
        workers += [self._make(kind) for _ in range(wanted - len(workers))]
        return workers[:wanted]

    @property
    def bytes(self) -> int:
        """What all that were made take."""
        return sum(worker.bytes for workers in self._by_kind.values() for worker in workers)


def lights_of(by_light: Mapping[int, tuple[WorkerT, int]]) -> dict[WorkerT, list[int]]:
    """By worker at work: its lights, in the order of their indices there."""
    lights: dict[WorkerT, list[int]] = {}
    for light, (worker, _) in by_light.items():
        lights.setdefault(worker, []).append(light)
    return lights
