"""The choices of a fit that are the user's."""

from __future__ import annotations

import dataclasses
import os


@dataclasses.dataclass(frozen=True)
class Settings:
    """How a fit is done.

    horizon: the longest segments, in natural periods of the rig (in units of 400 samples where it has no
    springs). The fit works its way up to them and stops earlier where the model cannot follow the record so
    far; None is the whole record, followed or not. effects: keys of effects that take part; free: rig
    parameters that are fitted too, under a prior around their stated values; starts: how many descents;
    descent_iterations each; resolution: integration steps on one ring of the contact in the shortest
    segments; seed of the random starts; workers: threads.
    """

    horizon: float | None = 16.0
    effects: tuple[str, ...] = ()
    free: tuple[str, ...] = ()
    starts: int = 8
    descent_iterations: int = 40
    resolution: float = 64.0
    seed: int = 0
    workers: int = dataclasses.field(default_factory=lambda: os.cpu_count() or 1)
