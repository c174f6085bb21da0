"""The choices of a diagnosis that are the user's."""

from __future__ import annotations

import dataclasses
import os


@dataclasses.dataclass(frozen=True)
class DiagnosisSettings:
    """How a diagnosis is done.

    hold_out: files of runs that take no part in choosing and fitting, besides those that rig.toml marks;
    where neither names any, a third of the runs or, with fewer than four runs, every third stretch of
    segments is held out. seed of everything random; workers: threads.
    """

    hold_out: tuple[str, ...] = ()
    seed: int = 0
    workers: int = dataclasses.field(default_factory=lambda: os.cpu_count() or 1)
