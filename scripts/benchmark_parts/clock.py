"""Times of several candidates taken in turns, so that a busy machine disturbs all of them alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

Candidates = Mapping[str, Callable[[], object]]


class Spent(NamedTuple):
    """The least time by the wall's clock and the least time of the processor, all threads together [s]."""

    wall: float
    processor: float


def fastest(candidates: Candidates, repeats: int) -> dict[str, Spent]:
    """The least times of each candidate over `repeats` rounds, after one round that nobody times."""
    for candidate in candidates.values():
        candidate()
    found = dict.fromkeys(candidates, Spent(float("inf"), float("inf")))
    for _ in range(repeats):
        for name, candidate in candidates.items():
            wall, processor = time.perf_counter(), time.process_time()
            candidate()
            taken = time.perf_counter() - wall, time.process_time() - processor
            found[name] = Spent(*map(min, found[name], taken))
    return found
